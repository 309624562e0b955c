"""Discovery in a ROS 2 domain: Cyclone DDS's settings from ROS's environment variables."""

from __future__ import annotations

import os
import re
import subprocess
import sys
from collections.abc import Mapping
from pathlib import Path
from xml.sax.saxutils import quoteattr

from voz.errors import ConfigError
from voz.files import MAX_SETTINGS_BYTES
from voz.settings import Ros2

MAX_LOCAL_PROGRAMS = 32
"""Programs on one computer that find each other without multicast, as in ROS 2's own Cyclone."""

MAX_SHOWN_DIGITS = 20
"""Characters of an invalid number that are shown."""

IGNORED_VENDORS = "1.15,1.16"
"""Fast DDS and Cyclone, by their vendor numbers.

ROS 2 matches types by name alone. Cyclone cannot read the type of a list from Fast DDS, and would
never connect to /diagnostics.
"""


def domain_number(settings: Ros2, environment: Mapping[str, str]) -> int:
    """Return the domain of the settings, or of `ROS_DOMAIN_ID`; ConfigError if that is invalid."""
    if settings.domain is not None:
        return settings.domain
    said = environment.get("ROS_DOMAIN_ID") or "0"
    if not said.isdecimal() or len(said) > MAX_SHOWN_DIGITS or int(said) > 232:
        raise ConfigError(
            f"ROS_DOMAIN_ID is {said[:MAX_SHOWN_DIGITS]!r}: set it to a number from 0 to 232"
        )
    return int(said)


def cyclone_settings(environment: Mapping[str, str]) -> str:
    """Write Cyclone's configuration so that it finds other programs as ROS 2's own does.

    Args:
        environment: `ROS_AUTOMATIC_DISCOVERY_RANGE`, `ROS_LOCALHOST_ONLY` and `ROS_STATIC_PEERS`
            mean what they mean to ROS 2; what `CYCLONEDDS_URI` says wins over them.

    Raises:
        ConfigError: there is no such range.
    """
    reach = environment.get("ROS_AUTOMATIC_DISCOVERY_RANGE") or "SUBNET"
    if environment.get("ROS_LOCALHOST_ONLY") == "1":
        reach = "LOCALHOST"
    if reach not in ("SUBNET", "LOCALHOST", "OFF", "SYSTEM_DEFAULT"):
        raise ConfigError(
            f"ROS_AUTOMATIC_DISCOVERY_RANGE is {reach!r}: "
            "set it to SUBNET, LOCALHOST, OFF or SYSTEM_DEFAULT"
        )
    own = environment.get("CYCLONEDDS_URI", "")
    found = _discovery(reach, environment, loopback=not _names_interfaces(own))
    names = f"<IgnoreTypeInformation>{IGNORED_VENDORS}</IgnoreTypeInformation>"
    return (
        f"<CycloneDDS><Domain><Compatibility>{names}</Compatibility>{found}</Domain></CycloneDDS>,"
        f"{own}"
    )


def _names_interfaces(uri: str) -> bool:
    """Whether the user chooses interfaces; Cyclone would add ours to those.

    Args:
        uri: names of files and pieces of XML, with commas between them.
    """
    texts = [uri]
    for name in uri.split(","):  # pieces of XML are no files; Cyclone reports missing ones
        try:
            with Path(name.strip().removeprefix("file://")).open("rb") as file:
                texts.append(file.read(MAX_SETTINGS_BYTES).decode(errors="replace"))
        except (OSError, ValueError):
            continue
    said = re.sub(r"<!--.*?-->", "", "\n".join(texts), flags=re.DOTALL)
    return "<networkinterface" in said.lower()


def _discovery(reach: str, environment: Mapping[str, str], loopback: bool) -> str:
    if reach == "SYSTEM_DEFAULT":
        return ""
    if reach == "OFF":
        # Only a program with the same tag could find this one.
        return (
            "<General><AllowMulticast>false</AllowMulticast></General><Discovery>"
            f"<ParticipantIndex>none</ParticipantIndex><Tag>ros_discovery_off_{os.getpid()}</Tag>"
            "</Discovery>"
        )
    interfaces = '<Interfaces><NetworkInterface address="127.0.0.1"/></Interfaces>'
    here = (
        f"<General>{interfaces if loopback else ''}<AllowMulticast>false</AllowMulticast></General>"
    )
    named = environment.get("ROS_STATIC_PEERS", "").split(";")
    # Without a network there is no multicast, so this computer is always asked. By its number:
    # without an /etc/hosts nobody knows `localhost`, and Cyclone aborts the process.
    peers = "".join(f"<Peer address={quoteattr(p)}/>" for p in ["127.0.0.1", *filter(None, named)])
    return (
        f"{here if reach == 'LOCALHOST' else ''}"
        "<Discovery><ParticipantIndex>auto</ParticipantIndex>"
        f"<MaxAutoParticipantIndex>{MAX_LOCAL_PROGRAMS}</MaxAutoParticipantIndex>"
        f"<Peers>{peers}</Peers></Discovery>"
    )


CHECKED_VARIABLES = ("ROS_STATIC_PEERS", "CYCLONEDDS_URI")
"""What users write into Cyclone's configuration; the rest is valid."""

CHECK_PROGRAM = """
import resource, sys
from cyclonedds.domain import Domain
resource.setrlimit(resource.RLIMIT_CORE, (0, 0))
Domain(int(sys.argv[1]), sys.argv[2])
"""

CHECK_TIMEOUT = 20.0
"""Time limit for resolving the names, s."""


def check_cyclone(number: int, configuration: str, environment: Mapping[str, str]) -> None:
    """Raise ConfigError if Cyclone cannot make a domain with the users' environment variables.

    Another process tries: Cyclone aborts for a peer with an unknown name.
    """
    said = " and ".join(name for name in CHECKED_VARIABLES if environment.get(name))
    if not said:
        return
    command = [sys.executable, "-c", CHECK_PROGRAM, str(number), configuration]
    try:
        done = subprocess.run(
            command,
            stdin=subprocess.DEVNULL,
            capture_output=True,
            text=True,
            errors="replace",
            timeout=CHECK_TIMEOUT,
        )
    except (OSError, ValueError) as error:  # too long, or with a NUL in it
        raise ConfigError(f"{said} cannot be used ({error}); correct it") from error
    except subprocess.TimeoutExpired as error:
        raise ConfigError(f"{said}: no answer in {CHECK_TIMEOUT:g} s; correct it") from error
    if done.returncode:
        raise ConfigError(f"{said} cannot be used ({_reason(done.stderr)}); correct it")


def _reason(complaint: str) -> str:
    """Return the first line without the time, the domain and the program's name."""
    first = complaint.partition("\n")[0]
    return re.sub(r"^[\d.]+ \[\w*\]\s+\S+: ", "", first).strip() or "it ends the process"
