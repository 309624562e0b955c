"""The systemd unit that runs voz. Pure."""

from __future__ import annotations

import os
import re
from collections.abc import Mapping, Sequence

from voz.errors import ServiceError

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
