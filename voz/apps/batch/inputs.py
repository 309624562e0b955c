"""Which recordings are meant: files, folders, manifests, addresses, and lists of all of them."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from pathlib import Path
from typing import NamedTuple

from voz.apps.batch.remote import is_remote, require_fsspec
from voz.apps.recordings.clips import Clip
from voz.apps.recordings.manifest import read_manifest
from voz.errors import ConfigError
from voz.files import shown_path

AUDIO_FORMATS = "aif aifc aiff au caf flac mp3 oga ogg opus rf64 sph w64 wav"
AUDIO_ENDINGS = frozenset(f".{name}" for name in AUDIO_FORMATS.split())
"""Of what is taken from a folder, if nobody says otherwise."""

MANIFEST_ENDING = ".tsv"


class Inputs(NamedTuple):
    """What is to be decoded.

    Attributes:
        names: paths and addresses, each once.
        clips: what is said in those of manifests.
    """

    names: list[str]
    clips: list[Clip]


def find_inputs(given: Iterable[str], glob: str | None, listed: Iterable[str]) -> Inputs:
    """Find the recordings that are meant, each once, in the order in which they are named.

    Args:
        given: files, folders, manifests and addresses; `-` stands for the list.
        glob: which files of folders; None takes all that may be recordings, however deep.
        listed: the list, each a file, a folder, a manifest or an address.

    Raises:
        ConfigError: a manifest cannot be read, or an address be opened.
    """
    names: dict[str, None] = {}
    clips: list[Clip] = []
    for one in given:
        for each in listed if one == "-" else (one,):
            if each.endswith(MANIFEST_ENDING) and not is_remote(each):
                clips += (read := read_manifest(Path(each), streams=True))
                names.update(dict.fromkeys(str(clip.path) for clip in read))
            elif each:
                names.update(dict.fromkeys(_found(each, glob)))
    if any(map(is_remote, names)):
        require_fsspec()
    return Inputs(list(names), clips)


def shard_of(names: list[str], shard: str) -> list[str]:
    """Take every so many of the recordings.

    Args:
        names: all of them.
        shard: which of how many, as `3/16`.

    Raises:
        ConfigError: there is no such shard.
    """
    number, count = parse_shard(shard)
    return names[number - 1 :: count]


def parse_shard(shard: str) -> tuple[int, int]:
    """Read which shard of how many is meant; raises ConfigError if that cannot be."""
    first, _, second = shard.partition("/")
    if not (first.isascii() and first.isdigit() and second.isascii() and second.isdigit()):
        raise ConfigError(f'"{shard}" is no shard; write for instance 3/16, the third of 16')
    number, count = int(first), int(second)
    if not 1 <= number <= count <= 1_000_000:
        raise ConfigError(f"there is no shard {shard}; the first of 16 is 1/16, the last 16/16")
    return number, count


def _found(name: str, glob: str | None) -> Iterator[str]:
    """The recordings in a folder in the order of their names; or what is none, as it is."""
    path = Path(name)
    if is_remote(name) or "\0" in name or not _is_folder(path):
        yield name
        return
    try:
        inside = sorted(path.glob(glob or "**/*"))
    except (ValueError, NotImplementedError, OSError) as error:
        raise ConfigError(f"{glob}: cannot be looked for ({error}); write e.g. **/*.wav") from None
    found = [each for each in inside if (glob or each.suffix.lower() in AUDIO_ENDINGS)]
    found = [each for each in found if not each.is_dir()]
    if not found:
        what = f"that matches {glob}" if glob else "with the ending of a recording; use --glob"
        raise ConfigError(f"{shown_path(path)}: holds no file {what}")
    yield from map(str, found)


def _is_folder(path: Path) -> bool:
    try:
        return path.is_dir()
    except OSError:  # a name that is too long, for instance
        return False
