"""Profiles of speakers: how far to trust what is heard of each."""

from __future__ import annotations

import re
import shutil
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Annotated

import msgspec

from voz.errors import ConfigError
from voz.files import (
    MAX_SETTINGS_BYTES,
    atomic_write,
    data_folder,
    os_errors_as_config_error,
    read_json,
)
from voz.records import CheckedRecord, Finite

PROFILE_FILE = "profile.json"


class Profile(CheckedRecord, frozen=True, forbid_unknown_fields=True):
    """What is known of a speaker."""

    # Added to those of each confidence
    log_odds: Annotated[float, msgspec.Meta(ge=-10, le=10)] = 0.0
    # SHA-256 of its acoustic model; empty for pocketsphinx's own, None for any
    model: str | None = None

    def check_model(self, model: str) -> None:
        """Raise ConfigError if it was made with another acoustic model."""
        if self.model not in (None, model):
            raise ConfigError(
                "the profile was made with another acoustic model; make it again with "
                "`voz calibrate`, or leave out --profile"
            )


class _ProfileFile(Profile, frozen=True, forbid_unknown_fields=True):
    """A profile as it is read; `start` and `mllr` are of an older voz."""

    start: Mapping[str, Finite | tuple[Finite, ...]] | None = None
    mllr: str | None = None


def profile_folder(name: str) -> Path:
    """The folder of a profile, which need not exist; ConfigError for an invalid name."""
    if not re.fullmatch(r"\w[\w.-]{0,59}", name):
        raise ConfigError(
            f"{name!r} cannot be the name of a profile; use letters, digits, - and _, up to 60"
        )
    return data_folder("profiles") / name


def profile_names() -> list[str]:
    """The names of all profiles."""
    return sorted(path.parent.name for path in profile_folder("_").parent.glob(f"*/{PROFILE_FILE}"))


def delete_profile(name: str) -> None:
    """Delete a profile with its recordings; raises ConfigError if that fails."""
    folder = profile_folder(name)
    try:
        shutil.rmtree(folder)
    except FileNotFoundError:
        raise ConfigError(f'there is no profile "{name}" in {folder.parent}') from None
    except OSError as error:
        raise ConfigError(f"{folder}: cannot be deleted ({error.strerror})") from error


def load_profile(name: str, warn: Callable[[str], None] = lambda _: None) -> Profile:
    """Read what `voz calibrate` wrote; raises ConfigError if that fails.

    `warn` gets a line about what an older voz wrote and this one does not use.
    """
    folder = profile_folder(name)
    path = folder / PROFILE_FILE
    again = f"make it with `voz calibrate {name}`"
    if not path.exists():
        raise ConfigError(f'there is no profile "{name}" in {folder.parent}; {again}')
    found = read_json(path, _ProfileFile, ConfigError, again, MAX_SETTINGS_BYTES)
    if found.start is not None or found.mllr is not None:
        warn(f"{path}: what an older voz learned of the voice is no longer used; {again} again")
    return Profile(found.log_odds, found.model)


def save_profile(name: str, profile: Profile) -> Path:
    """Write a profile as readable JSON; returns the file, raises ConfigError if that fails."""
    path = profile_folder(name) / PROFILE_FILE
    with os_errors_as_config_error(path):
        path.parent.mkdir(parents=True, exist_ok=True)
        with atomic_write(path, "wb") as file:
            file.write(msgspec.json.format(msgspec.json.encode(profile), indent=2) + b"\n")
    return path
