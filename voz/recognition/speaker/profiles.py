"""Files with what was learned of speakers and microphones."""

from __future__ import annotations

import re
import shutil
from pathlib import Path
from typing import Annotated

import msgspec
from msgspec.structs import replace

from voz.errors import ConfigError
from voz.files import (
    MAX_SETTINGS_BYTES,
    atomic_write,
    data_folder,
    os_errors_as_config_error,
    read_json,
    read_text,
    sha256,
    shown_path,
)
from voz.recognition.speaker.adaptation import StartVector, is_transforms
from voz.records import CheckedRecord

USUAL_PROFILE = "default"
"""The profile when none is named."""

PROFILE_FILE = "profile.json"
MLLR_FILE = "mllr.txt"
LEARNED_FOLDER = "learnt"


class Profile(CheckedRecord, frozen=True, forbid_unknown_fields=True):
    """What is known of a speaker and a microphone."""

    start: StartVector = StartVector()  # of the cepstral mean
    mllr: str | None = None  # file with the transform of the acoustic model
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


def load_profile(name: str) -> Profile:
    """Read what `voz calibrate` wrote; raises ConfigError if that fails."""
    folder = profile_folder(name)
    path = folder / PROFILE_FILE
    again = f"make it with `voz calibrate {name}`"
    if not path.exists():
        raise ConfigError(f'there is no profile "{name}" in {folder.parent}; {again}')
    profile = read_json(path, Profile, ConfigError, again, MAX_SETTINGS_BYTES)
    if profile.mllr is None:
        return profile
    mllr = folder / profile.mllr
    if not is_transforms(read_text(mllr, ConfigError, again, MAX_SETTINGS_BYTES)):
        raise ConfigError(f"{mllr}: is spoilt; {again}")
    if shown_path(mllr) != str(mllr):
        raise ConfigError(f"{shown_path(mllr)}: is no name in UTF-8; set XDG_DATA_HOME to another")
    return replace(profile, mllr=str(mllr))


def save_profile(name: str, profile: Profile) -> Path:
    """Write a profile as readable JSON, and delete what was learned with the one before.

    Returns:
        The file; that of the transform is copied beside it.

    Raises:
        ConfigError: it cannot be written.
    """
    folder = profile_folder(name)
    path = folder / PROFILE_FILE
    kept = replace(profile, start=_rounded(profile.start), mllr=profile.mllr and MLLR_FILE)
    with os_errors_as_config_error(path):
        folder.mkdir(parents=True, exist_ok=True)
        with atomic_write(path, "wb") as file:
            file.write(msgspec.json.format(msgspec.json.encode(kept), indent=2) + b"\n")
            if profile.mllr:  # first, so that a profile never names what is not there
                _write(folder / MLLR_FILE, Path(profile.mllr).read_bytes())
        if not profile.mllr:
            (folder / MLLR_FILE).unlink(missing_ok=True)
        for learned in (folder / LEARNED_FOLDER).glob("*.json"):
            learned.unlink(missing_ok=True)
    return path


def learned_file(profile: str, device: str) -> Path:
    """The file of what was learned of a profile and a microphone; raises ConfigError."""
    name = re.sub(r"[^A-Za-z0-9]+", "-", device)[:60].strip("-")
    # Two devices may differ only in what a file name cannot have.
    digest = sha256(device.encode(errors="backslashreplace")).hexdigest()[:8]
    return profile_folder(profile) / LEARNED_FOLDER / f"{name}-{digest}.json"


def load_learned(path: Path) -> tuple[StartVector, str | None]:
    """Read a `learned_file`, if it exists; also returns a warning if it cannot be used."""
    try:
        path.stat()
    except FileNotFoundError:
        return StartVector(), None
    except OSError:
        pass  # is told when it is read
    try:
        return read_json(
            path, StartVector, ConfigError, "learning starts anew", MAX_SETTINGS_BYTES
        ), None
    except ConfigError as error:
        return StartVector(), str(error)


def save_learned(path: Path, vector: StartVector) -> str | None:
    """Write a `learned_file`; returns a warning for the user if that fails, as robots go on."""
    try:
        path.parent.mkdir(parents=True, exist_ok=True)
        _write(path, msgspec.json.encode(_rounded(vector)) + b"\n")
    except OSError as error:
        return f"{path}: cannot be written ({error.strerror}); what was learned will be lost"
    return None


def _write(path: Path, data: bytes) -> None:
    with atomic_write(path, "wb") as file:
        file.write(data)


def _rounded(vector: StartVector) -> StartVector:
    return replace(vector, shift=tuple(round(number, 3) for number in vector.shift))
