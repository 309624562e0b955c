"""The result of a check."""

from __future__ import annotations

from collections.abc import Set
from typing import Final

from msgspec import Struct

from voz.errors import VozError
from voz.robot.ros_topics import ONE_SENDER

JSON_NAMES: Final = {
    "part": "what", "ok": "well", "status": "told", "remedy": "to_do", "required": "needed",
}  # fmt: skip
"""The fields as `voz doctor --json` writes them."""


class Finding(Struct, frozen=True, rename=JSON_NAMES):
    """The result of checking one part."""

    part: str  # its name
    ok: bool  # whether it does what it should
    status: str  # how it is, in words
    remedy: str | None = None  # what to do if it is not ok
    required: bool = True  # whether the robot does not obey, or not speak, without it


def failed(part: str, error: VozError, required: bool = True) -> Finding:
    """Make a finding of an error."""
    return Finding(part, False, error.problem, error.remedy, required)


def senders_finding(system: str, topic: str, others: Set[str]) -> Finding:
    """Tell who else sends velocities on a topic, by their names."""
    part = f"{system} senders"
    if others:
        status = f"velocities on {topic} come from {' and '.join(sorted(others))}"
        return Finding(part, False, status, ONE_SENDER, required=False)
    return Finding(part, True, f"nobody sends velocities on {topic}", required=False)
