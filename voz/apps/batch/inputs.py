"""Finds the recordings to decode: files, folders, manifests, addresses, and lists of these."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

from voz.apps.batch.locations import is_remote, shown_name
from voz.apps.batch.outcomes import ManifestFields, column_name
from voz.apps.recordings.manifest import Clip, parse_records, read_manifest
from voz.audio.sound_files import ENDINGS, UNREADABLE_ENDINGS, convert_advice
from voz.errors import ConfigError
from voz.extras import require
from voz.files import read_text, shown_path

MOST_LEFT_OUT_NAMED = 5
"""Recordings that are left out and named to the user; the others are counted."""

MANIFEST_ENDING = ".tsv"


@dataclass(frozen=True)
class Inputs:
    """What is to be decoded."""

    names: list[str]  # paths and addresses, each once
    clips: list[Clip]  # what is said in those of manifests
    columns: tuple[str, ...]  # of manifests, by their names in an output
    manifest: Mapping[str, ManifestFields]  # what they say of recordings, by names in results
    left_out: list[Path]  # files of folders with sound that voz cannot read

    @property
    def left_out_warning(self) -> str | None:
        """Which recordings in folders are left out, and what to do; None if none are."""
        return _left_out_warning(self.left_out) if self.left_out else None


def find_inputs(given: Iterable[str], glob: str | None, listed: Iterable[str]) -> Inputs:
    """Find the recordings, each once, in the order in which they are named.

    Args:
        given: files, folders, manifests and addresses; `-` stands for the list.
        glob: which files of folders; None takes all with the ending of a recording, however deep,
            and notes those of other formats that have no converted one beside them.
        listed: the list, of the same kinds.

    Raises:
        ConfigError: a manifest cannot be read, or fsspec is needed and missing.
    """
    names: dict[str, None] = {}
    clips: list[Clip] = []
    columns: dict[str, None] = {}
    manifest: dict[str, ManifestFields] = {}
    left_out: dict[Path, None] = {}
    for one in given:
        for each in listed if one == "-" else (one,):
            if each.endswith(MANIFEST_ENDING) and not is_remote(each):
                clips += (read := read_manifest(Path(each), streams=True))
                names.update(dict.fromkeys(str(clip.path) for clip in read))
                for clip, fields in zip(read, _manifest_fields(Path(each)), strict=True):
                    columns.update(dict.fromkeys(fields))
                    file = shown_name(str(clip.path))
                    manifest[file] = _agreed(manifest.get(file), fields)
            elif each:
                names.update(dict.fromkeys(_found(each, glob, left_out)))
    if any(map(is_remote, names)):
        require("remote", "fsspec")
    return Inputs(list(names), clips, tuple(columns), manifest, list(left_out))


def shard_of(names: list[str], shard: str) -> list[str]:
    """Take every n-th of the recordings, by a shard such as `3/16`; raises ConfigError."""
    number, count = parse_shard(shard)
    return names[number - 1 :: count]


def parse_shard(shard: str) -> tuple[int, int]:
    """Read the number of a shard and of how many, as `3/16`; raises ConfigError."""
    first, _, second = shard.partition("/")
    if not (first.isascii() and first.isdigit() and second.isascii() and second.isdigit()):
        raise ConfigError(f'invalid shard "{shard}"; write for instance 3/16, the third of 16')
    number, count = int(first), int(second)
    if not 1 <= number <= count <= 1_000_000:
        raise ConfigError(f"there is no shard {shard}; the first of 16 is 1/16, the last 16/16")
    return number, count


def _found(name: str, glob: str | None, left_out: dict[Path, None]) -> Iterator[str]:
    """The recordings in a folder in the order of their names; any other name as it is.

    Those in other formats are added to `left_out`.
    """
    path = Path(name)
    if is_remote(name) or "\0" in name or not _is_folder(path):
        yield name
        return
    try:
        inside = sorted(path.glob(glob or "**/*"))
    except (ValueError, NotImplementedError, OSError) as error:
        raise ConfigError(f"{glob}: invalid pattern ({error}); write e.g. **/*.wav") from None
    found = [each for each in inside if (glob or each.suffix.lower() in ENDINGS)]
    found = [each for each in found if not each.is_dir()]
    others = [] if glob else _unreadable(inside, found)
    left_out.update(dict.fromkeys(others))
    if not found and others:
        raise ConfigError(f"{shown_path(path)}: {_left_out_warning(others)}")
    if not found:
        what = f"that matches {glob}" if glob else "with the ending of a recording; use --glob"
        raise ConfigError(f"{shown_path(path)}: holds no file {what}")
    yield from map(str, found)


def _unreadable(inside: Iterable[Path], found: Iterable[Path]) -> list[Path]:
    """The recordings in other formats, but those of which a converted one is beside them."""
    converted = {each.with_suffix("") for each in found}
    return [
        each
        for each in inside
        if each.suffix.lower() in UNREADABLE_ENDINGS
        and not converted & {each, each.with_suffix("")}  # a.wav or a.m4a.wav beside a.m4a
        and not each.is_dir()
    ]


def _left_out_warning(paths: Sequence[Path]) -> str:
    named = ", ".join(shown_path(path) for path in paths[:MOST_LEFT_OUT_NAMED])
    more = len(paths) - MOST_LEFT_OUT_NAMED
    rest = f" and {more:,} more" if more > 0 else ""
    return f"left out, as voz does not read the format: {named}{rest}; {convert_advice(paths[0])}"


def _manifest_fields(path: Path) -> Iterator[dict[str, str]]:
    """What each line of a manifest says, by the columns of outputs."""
    for record in parse_records(read_text(path, ConfigError, "name a manifest, a .tsv file")):
        fields = {name.strip(): value.strip() for name, value in record.items()}
        yield {column_name(name): value for name, value in fields.items() if name}


def _agreed(known: ManifestFields | None, fields: ManifestFields) -> ManifestFields:
    """What the lines of one recording, as of a stream's stretches, say alike."""
    return {n: v for n, v in fields.items() if v and (known is None or known.get(n) == v)}


def _is_folder(path: Path) -> bool:
    try:
        return path.is_dir()
    except OSError:  # a name that is too long, for instance
        return False
