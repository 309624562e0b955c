"""Tries Cyclone's settings in another process: Cyclone aborts for a peer with an unknown name."""

from __future__ import annotations

import re
import subprocess
import sys
from collections.abc import Mapping

from voz.errors import ConfigError

VARIABLES = ("ROS_STATIC_PEERS", "CYCLONEDDS_URI")
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
    """Raise ConfigError if Cyclone cannot make a domain with the users' environment variables."""
    said = " and ".join(name for name in VARIABLES if environment.get(name))
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
