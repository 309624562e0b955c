"""What is kept of a speaker and a microphone from one run to the next. An edge: it keeps files."""

from __future__ import annotations

import hashlib
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
    shown_path,
)
from voz.recognition.speaker.adaptation import StartVector
from voz.recognition.speaker.mllr import is_transforms
from voz.records import CheckedRecord

USUAL_PROFILE = "default"
"""Whoever does not say who speaks."""

PROFILE_FILE = "profile.json"
MLLR_FILE = "mllr.txt"
LEARNT_FOLDER = "learnt"


class Profile(CheckedRecord, frozen=True, forbid_unknown_fields=True):
    """What is known of a speaker and a microphone before they are heard.

    Attributes:
        start: where the cepstral mean starts.
        mllr: a file with the transform of the acoustic model; None leaves it as it is.
        log_odds: what is added to the log-odds of each confidence: a speaker who is understood,
            but never for sure, is worth more trust.
        model: the SHA-256 of the acoustic model that it was made with, empty for pocketsphinx's
            own; None fits any.
    """

    start: StartVector = StartVector()
    mllr: str | None = None
    log_odds: Annotated[float, msgspec.Meta(ge=-10, le=10)] = 0.0
    model: str | None = None

    def check_model(self, model: str) -> None:
        """Refuse to be used with another acoustic model than it was made with.

        Raises:
            ConfigError: it is another one.
        """
        if self.model not in (None, model):
            raise ConfigError(
                "the profile was made with another acoustic model; make it again with "
                "`voz calibrate`, or leave out --profile"
            )


def profile_folder(name: str) -> Path:
    """Name the folder of a profile, which need not be there.

    Args:
        name: what the user calls it.

    Returns:
        A path under `$XDG_DATA_HOME/voz/profiles`, or `~/.local/share/voz/profiles`.

    Raises:
        ConfigError: the name cannot be that of a folder, or there is no home folder.
    """
    if not re.fullmatch(r"\w[\w.-]{0,59}", name):
        raise ConfigError(
            f"{name!r} cannot be the name of a profile; use letters, digits, - and _, up to 60"
        )
    return data_folder("profiles") / name


def profile_names() -> list[str]:
    """List the profiles that there are."""
    return sorted(path.parent.name for path in profile_folder("_").parent.glob(f"*/{PROFILE_FILE}"))


def delete_profile(name: str) -> None:
    """Delete a profile with its recordings.

    Raises:
        ConfigError: there is none, or it cannot be deleted.
    """
    folder = profile_folder(name)
    try:
        shutil.rmtree(folder)
    except FileNotFoundError:
        raise ConfigError(f'there is no profile "{name}" in {folder.parent}') from None
    except OSError as error:
        raise ConfigError(f"{folder}: cannot be deleted ({error.strerror})") from error


def load_profile(name: str) -> Profile:
    """Read what `voz calibrate` has kept.

    Raises:
        ConfigError: there is no such profile, or a file of it cannot be used.
    """
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
    """Keep a profile as readable JSON, and forget what was learnt while one before it was used.

    Args:
        name: what the user calls it.
        profile: what to keep; the file of its transform is copied.

    Returns:
        The file.

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
        for learnt in (folder / LEARNT_FOLDER).glob("*.json"):
            learnt.unlink(missing_ok=True)
    return path


def learnt_file(profile: str, device: str) -> Path:
    """Name the file that keeps what was learnt about a speaker and a microphone in use.

    Args:
        profile: the name of the profile.
        device: the microphone.

    Returns:
        A path in the folder of the profile.

    Raises:
        ConfigError: the name cannot be that of a profile.
    """
    name = re.sub(r"[^A-Za-z0-9]+", "-", device)[:60].strip("-")
    # Two devices may differ only in what a file name cannot have.
    digest = hashlib.sha256(device.encode(errors="backslashreplace")).hexdigest()[:8]
    return profile_folder(profile) / LEARNT_FOLDER / f"{name}-{digest}.json"


def load_learnt(path: Path) -> tuple[StartVector, str | None]:
    """Read what was learnt before.

    Args:
        path: a `learnt_file`; it need not be there.

    Returns:
        The vector, and a line for the user if there is a file that cannot be used; then it is
        as if nothing had been learnt.
    """
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


def save_learnt(path: Path, vector: StartVector) -> str | None:
    """Write what was learnt.

    Args:
        path: a `learnt_file`; its folder is made if need be.
        vector: what was learnt.

    Returns:
        A line for the user if it cannot be written: no reason to stop a robot.
    """
    try:
        path.parent.mkdir(parents=True, exist_ok=True)
        _write(path, msgspec.json.encode(_rounded(vector)) + b"\n")
    except OSError as error:
        return f"{path}: cannot be written ({error.strerror}); what was learnt will be lost"
    return None


def _write(path: Path, data: bytes) -> None:
    with atomic_write(path, "wb") as file:
        file.write(data)


def _rounded(vector: StartVector) -> StartVector:
    return replace(vector, shift=tuple(round(number, 3) for number in vector.shift))
