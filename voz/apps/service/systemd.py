"""Installs the unit with systemd's programs, for the user who calls. An edge."""

from __future__ import annotations

import getpass
import os
import subprocess
import sys
import sysconfig
from collections.abc import Iterator, Sequence
from pathlib import Path

from voz.apps.service.unit import unit
from voz.errors import ServiceError
from voz.files import atomic_write

NAME = "voz.service"

PATIENCE = 30.0
"""For an answer of systemd's, s: to stop voz takes a second or two."""


def unit_file() -> Path:
    """Where the user's own units are."""
    base = Path(os.environ.get("XDG_CONFIG_HOME", ""))
    return (base if base.is_absolute() else Path.home() / ".config") / "systemd" / "user" / NAME


def unit_for(options: Sequence[str]) -> str:
    """Write the unit that runs voz with these options of `voz run`, in this folder."""
    script = Path(sysconfig.get_path("scripts")) / "voz"
    program = [str(script)] if script.is_file() else [sys.executable, "-m", "voz"]
    return unit([*program, "run", *options], str(Path.cwd()), os.environ)


def install(options: Sequence[str]) -> Iterator[str]:
    """Write the unit, start it, and let it start with the computer.

    Args:
        options: of `voz run`.

    Yields:
        What was done, in words.

    Raises:
        ServiceError: there is no systemd for this user, or it refuses.
    """
    _systemctl("show-environment")  # before anything is written
    path = unit_file()
    _write(path, unit_for(options))
    yield f"written: {path}"
    _systemctl("daemon-reload")
    _systemctl("enable", NAME)
    _systemctl("restart", NAME)
    yield "started; `journalctl --user -u voz -f` shows what it says"
    yield _linger()


def uninstall() -> Iterator[str]:
    """Stop it, and remove the unit.

    Yields:
        What was done, in words.

    Raises:
        ServiceError: it is not installed, or systemd refuses.
    """
    path = unit_file()
    if not path.is_file():
        raise ServiceError(f"{path}: is not there; `voz service install` writes it")
    _systemctl("disable", "--now", NAME)
    yield "stopped: zero velocity was the last it sent"
    path.unlink()
    _systemctl("daemon-reload")
    yield f"removed: {path}"


def status() -> tuple[str, bool]:
    """Tell how it is.

    Returns:
        What systemd says, and whether it runs.

    Raises:
        ServiceError: there is no systemd for this user.
    """
    _systemctl("show-environment")
    done = _run("systemctl", "--user", "status", "--no-pager", NAME)
    return (done.stdout or done.stderr).rstrip("\n"), done.returncode == 0


def _linger() -> str:
    """Let the user's services start before anybody logs in."""
    user = getpass.getuser()
    shown = _run("loginctl", "show-user", user, "--property=Linger", "--value")
    if shown.stdout.strip() == "yes":
        return "it starts with the computer"
    if _run("loginctl", "--no-ask-password", "enable-linger").returncode == 0:
        return "it starts with the computer (`loginctl enable-linger` was called for that)"
    return (
        "it starts when you log in; to start it with the computer: "
        f"sudo loginctl enable-linger {user}"
    )


def _write(path: Path, text: str) -> None:
    try:
        path.parent.mkdir(parents=True, exist_ok=True)
        with atomic_write(path) as file:
            file.write(text)
    except OSError as error:
        raise ServiceError(f"{path}: cannot be written ({error.strerror}); see whose it is") from (
            error
        )


def _systemctl(*arguments: str) -> None:
    done = _run("systemctl", "--user", *arguments)
    if done.returncode:
        said = " ".join(done.stderr.split()) or f"exit code {done.returncode}"
        raise ServiceError(
            f"`systemctl --user {' '.join(arguments)}` fails ({said}); "
            "`voz service install --print` shows the unit, for a system that has systemd for users"
        )


def _run(*command: str) -> subprocess.CompletedProcess[str]:
    try:
        return subprocess.run(
            command,
            stdin=subprocess.DEVNULL,
            capture_output=True,
            text=True,
            errors="replace",
            timeout=PATIENCE,
        )
    except OSError as error:
        raise ServiceError(
            f"there is no {command[0]} here ({error.strerror}); "
            "`voz service install --print` shows the unit, for a system that has systemd"
        ) from error
    except subprocess.TimeoutExpired as error:
        raise ServiceError(f"{command[0]} gives no answer in {PATIENCE:g} s; try again") from error
