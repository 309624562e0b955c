"""Lets a process of its own try what the environment says to Cyclone, which aborts its process.

It does so for a peer whose name is unknown, and complains of other things on standard error.
"""

from __future__ import annotations

import re
import subprocess
import sys
from collections.abc import Mapping

from voz.errors import ConfigError

VARIABLES = ("ROS_STATIC_PEERS", "CYCLONEDDS_URI")
"""What users write into Cyclone's configuration; the rest of it is known to be good."""

TRIAL = """
import resource, sys
from cyclonedds.domain import Domain
resource.setrlimit(resource.RLIMIT_CORE, (0, 0))
Domain(int(sys.argv[1]), sys.argv[2])
"""

PATIENCE = 20.0
"""For the names to be found, s."""


def try_out(number: int, configuration: str, environment: Mapping[str, str]) -> None:
    """Find out whether a domain can be made with what users said of it.

    Args:
        number: of the domain.
        configuration: as `cyclone_settings` writes it.
        environment: where users said it.

    Raises:
        ConfigError: it cannot be.
    """
    said = " and ".join(name for name in VARIABLES if environment.get(name))
    if not said:
        return
    command = [sys.executable, "-c", TRIAL, str(number), configuration]
    try:
        done = subprocess.run(
            command,
            stdin=subprocess.DEVNULL,
            capture_output=True,
            text=True,
            errors="replace",
            timeout=PATIENCE,
        )
    except (OSError, ValueError) as error:  # too long, or with a NUL in it
        raise ConfigError(f"{said} cannot be used ({error}); correct it") from error
    except subprocess.TimeoutExpired as error:
        raise ConfigError(f"{said}: no answer in {PATIENCE:g} s; correct it") from error
    if done.returncode:
        raise ConfigError(f"{said} cannot be used ({_reason(done.stderr)}); correct it")


def _reason(complaint: str) -> str:
    """Take from the first line what stands behind the time, the domain and the program's name."""
    first = complaint.partition("\n")[0]
    return re.sub(r"^[\d.]+ \[\w*\]\s+\S+: ", "", first).strip() or "it ends the process"
