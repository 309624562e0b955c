"""All that is looked at, in the order in which it is told."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import AbstractContextManager

from voz.apps.doctor import hearing, optional, ros1, ros2, sound
from voz.apps.doctor.finding import Finding, not_well
from voz.apps.doctor.stopping import NAME, Base, base_stops
from voz.config import Config
from voz.errors import VozError

BASES: Mapping[str, Callable[[Config, str], AbstractContextManager[Base]]] = {
    "ros1": lambda settings, odometry: ros1.ros1_base(settings.ros1, odometry),
    "ros2": lambda settings, odometry: ros2.ros2_base(settings.ros2, odometry),
}
"""Reaches the base of a robot, by the robot's name."""


def findings(settings: Config, robots: Sequence[str], device: str | None) -> Iterator[Finding]:
    """Look at what a run needs; nothing moves.

    Args:
        settings: those of the run.
        robots: by their names.
        device: the microphone, by its number or a part of its name.
    """
    yield sound.microphone(device)
    yield sound.loudspeaker(settings.speech.enabled)
    yield sound.speech(settings.speech)
    yield from hearing.hearing(settings)
    yield from ros1.ros1(settings.ros1, "ros1" in robots)
    if "ros2" in robots:
        yield from ros2.ros2(settings.ros2)
    yield from optional.extras(frozenset({"ros2"}.intersection(robots)))


def stopping(settings: Config, robot: str, odometry: str | None) -> Finding:
    """Drive the base of a robot for a moment, and see whether it stops by itself.

    Args:
        settings: those of the robot.
        robot: one of `BASES`.
        odometry: the topic on which the base tells how it moves; None as the settings say.
    """
    try:
        topic = odometry or getattr(settings, robot).odom
        with BASES[robot](settings, topic) as base:
            return base_stops(base)
    except VozError as error:
        return not_well(NAME, error)
