"""The systemd unit that runs voz, installed with `systemctl --user`. An edge."""

from __future__ import annotations

import getpass
import os
import re
import shlex
import subprocess
import sys
import sysconfig
from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path

from voz.errors import ServiceError
from voz.files import atomic_write

KEPT_VARIABLES = (
    "PULSE_SERVER",
    "ROS_MASTER_URI",
    "ROS_IP",
    "ROS_HOSTNAME",
    "ROS_NAMESPACE",
    "ROS_DOMAIN_ID",
    "ROS_AUTOMATIC_DISCOVERY_RANGE",
    "ROS_LOCALHOST_ONLY",
    "ROS_STATIC_PEERS",
    "CYCLONEDDS_URI",
    "LD_LIBRARY_PATH",
    "PYTHONPATH",
)
"""Environment variables that a run reads and a service would lack, most of them ROS's."""

NO_TEXT = r"[\x00-\x1f\x7f-\x9f\ud800-\udfff]"

UNIT = """\
[Unit]
Description=voz, drives the robot by voice
After=pipewire.service pipewire-pulse.service wireplumber.service pulseaudio.service
# What it needs may come later than it, as a microphone or a ROS master: it never gives up.
StartLimitIntervalSec=0

[Service]
Type=exec
WorkingDirectory={folder}
Environment=PYTHONUNBUFFERED=1
{environment}ExecStart={command}
# Zero velocity is the last that voz sends after SIGTERM. Its watchdog takes no such signal: if voz
# crashed it still has to stop the robot, and with another mode it would be killed at once.
KillMode=control-group
TimeoutStopSec=10
SuccessExitStatus=143
Restart=on-failure
RestartSec=3
# What a voice does not need. A user's systemd can close no more than this without a user namespace,
# which many systems refuse: voz would not start. docs/service.md has how to open it.
NoNewPrivileges=yes
SystemCallArchitectures=native
SystemCallFilter=@system-service
SystemCallFilter=~@privileged
SystemCallErrorNumber=EPERM
RestrictAddressFamilies=AF_UNIX AF_INET AF_INET6 AF_NETLINK
RestrictNamespaces=yes
RestrictRealtime=yes
RestrictSUIDSGID=yes
LockPersonality=yes
KeyringMode=private

[Install]
WantedBy=default.target
"""


def unit_text(command: Sequence[str], folder: str, environment: Mapping[str, str]) -> str:
    """Return the text of the unit that runs a command in a folder.

    `KEPT_VARIABLES` of the environment are kept.

    Raises:
        ServiceError: a unit cannot hold the name of the folder.
    """
    if not folder.isprintable() or folder[-1:] in (" ", "\\"):
        why = "a unit cannot hold a folder whose name has line breaks, other bytes, or such an end"
        raise ServiceError(f"{folder}: {why}", "call it from a folder with another name")
    kept = {name: environment[name] for name in KEPT_VARIABLES if environment.get(name)}
    lines = [f"Environment={_quoted(f'{name}={value}')}\n" for name, value in kept.items()]
    program, *words = map(_quoted, command)
    # In all words but the first, systemd also expands variables.
    words = [program, *(word.replace("$", "$$") for word in words)]
    return UNIT.format(
        folder=folder.replace("%", "%%"), environment="".join(lines), command=" ".join(words)
    )


def _quoted(word: str) -> str:
    """Quote a word for systemd, where `%` begins a specifier."""
    word = word.replace("%", "%%")
    if re.fullmatch(r"[\w@%+=:,./-]+", word, re.ASCII):
        return word
    escaped = word.replace("\\", "\\\\").replace('"', '\\"')
    return f'"{re.sub(NO_TEXT, _hexadecimal, escaped)}"'


def _hexadecimal(character: re.Match[str]) -> str:
    """A control character or a byte that is not UTF-8, as systemd reads it."""
    return "".join(f"\\x{byte:02x}" for byte in os.fsencode(character[0]))


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
