"""Installs the unit with `systemctl --user`. An edge."""

from __future__ import annotations

import getpass
import os
import shlex
import subprocess
import sys
import sysconfig
from collections.abc import Iterator, Sequence
from pathlib import Path

from voz.apps.service.unit_file import unit_text
from voz.errors import ServiceError
from voz.files import atomic_write

UNIT_NAME = "voz.service"

SYSTEMD_TIMEOUT = 30.0
"""For systemd to answer, s: to stop voz takes a second or two."""


def unit_path() -> Path:
    """Where the unit file is."""
    base = Path(os.environ.get("XDG_CONFIG_HOME", ""))
    return (
        (base if base.is_absolute() else Path.home() / ".config") / "systemd" / "user" / UNIT_NAME
    )


def unit_for(options: Sequence[str]) -> str:
    """Return the unit that runs `voz run` with these options in this folder."""
    script = Path(sysconfig.get_path("scripts")) / "voz"
    program = [str(script)] if script.is_file() else [sys.executable, "-m", "voz"]
    return unit_text([*program, "run", *options], str(Path.cwd()), os.environ)


def install(options: Sequence[str]) -> Iterator[str]:
    """Write the unit, start it, and let it start with the computer; yields what was done, in words.

    Raises:
        ServiceError: there is no systemd for this user, or it reports an error.
    """
    _systemctl("show-environment")  # before anything is written
    path = unit_path()
    _write(path, unit_for(options))
    yield f"written: {path}"
    _systemctl("daemon-reload")
    _systemctl("enable", UNIT_NAME)
    _systemctl("restart", UNIT_NAME)
    yield "started; `journalctl --user -u voz -f` shows what it says"
    yield _linger()


def uninstall() -> Iterator[str]:
    """Stop it, and remove the unit; yields what was done, in words.

    Raises:
        ServiceError: it is not installed, or systemd reports an error.
    """
    path = unit_path()
    if not path.is_file():
        raise ServiceError(f"{path}: does not exist; `voz service install` writes it")
    _systemctl("disable", "--now", UNIT_NAME)
    yield "stopped: zero velocity was the last it sent"
    path.unlink()
    _systemctl("daemon-reload")
    yield f"removed: {path}"


def status() -> tuple[str, bool]:
    """Return what systemd says of the service, and whether it runs.

    Raises:
        ServiceError: there is no systemd for this user.
    """
    _systemctl("show-environment")
    done = _run("systemctl", "--user", "status", "--no-pager", UNIT_NAME)
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
        f"sudo loginctl enable-linger {shlex.quote(user)}"
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
            timeout=SYSTEMD_TIMEOUT,
        )
    except OSError as error:
        raise ServiceError(
            f"there is no {command[0]} here ({error.strerror}); "
            "`voz service install --print` shows the unit, for a system that has systemd"
        ) from error
    except subprocess.TimeoutExpired as error:
        raise ServiceError(
            f"{command[0]} did not answer in {SYSTEMD_TIMEOUT:g} s; try again"
        ) from error
