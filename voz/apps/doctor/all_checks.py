"""All checks, in the order in which they are shown."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import AbstractContextManager
from importlib.util import find_spec

from voz.apps.doctor.base_stop_check import BASE_STOPS, Base, check_stop
from voz.apps.doctor.finding import Finding, failed
from voz.apps.doctor.recognition_checks import check_recognition
from voz.apps.doctor.ros1_checks import check_ros1, open_ros1_base
from voz.apps.doctor.ros2_checks import check_ros2, open_ros2_base
from voz.apps.doctor.sound_checks import check_festival, check_loudspeaker, check_microphone
from voz.config import Config
from voz.errors import VozError
from voz.extras import how_to_install

BASES: Mapping[str, Callable[[Config, str], AbstractContextManager[Base]]] = {
    "ros1": lambda settings, odometry: open_ros1_base(settings.ros1, odometry),
    "ros2": lambda settings, odometry: open_ros2_base(settings.ros2, odometry),
}
"""Opens the base of a robot, by the robot's name."""

EXTRA_MODULES: Mapping[str, tuple[str, ...]] = {
    "bags": ("rosbags",),
    "report": ("jiwer", "matplotlib"),
    "ros2": ("cyclonedds",),
}
"""What each extra of pyproject.toml brings."""


def check_all(settings: Config, robots: Sequence[str], device: str | None) -> Iterator[Finding]:
    """Check what a run with these robots needs; nothing moves.

    `device` is the microphone, by its number or a part of its name.
    """
    yield check_microphone(device)
    yield check_loudspeaker(settings.speech.enabled)
    yield check_festival(settings.speech)
    yield from check_recognition(settings)
    yield from check_ros1(settings.ros1, "ros1" in robots)
    if "ros2" in robots:
        yield from check_ros2(settings.ros2)
    yield from check_extras(frozenset({"ros2"}.intersection(robots)))


def check_base_stops(settings: Config, robot: str, odometry: str | None) -> Finding:
    """Drive the base of one of `BASES` for a moment, and check whether it stops by itself.

    `odometry` is the topic of the base's odometry; None as the settings say.
    """
    try:
        topic = odometry or getattr(settings, robot).odom
        with BASES[robot](settings, topic) as base:
            return check_stop(base)
    except VozError as error:
        return failed(BASE_STOPS, error)


def check_extras(required: frozenset[str] = frozenset()) -> Iterator[Finding]:
    """Check which extras are installed, the `required` ones among them."""
    for extra, modules in EXTRA_MODULES.items():
        missing = [module for module in modules if find_spec(module) is None]
        status = f"there is no {' and no '.join(missing)}" if missing else "is installed"
        remedy = how_to_install(extra) if missing else None
        yield Finding(f"extra {extra}", not missing, status, remedy, extra in required)
