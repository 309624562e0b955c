"""Whether a base stops by itself when no more velocities come, according to its odometry.

It turns on the spot, which takes no room, and then gets nothing for a second. Whatever ends this,
zero velocity is the last that it gets.
"""

from __future__ import annotations

import queue
import time
from collections.abc import Callable, Set
from contextlib import suppress
from dataclasses import dataclass
from queue import SimpleQueue
from typing import Any, Protocol

from voz.apps.doctor.finding import Finding
from voz.control.safety import zero_at_the_end
from voz.errors import RobotError
from voz.process import signals

BASE_STOPS = "base stops"

TURN_SPEED = 0.2
"""rad/s: slower, and friction holds some bases; 1 turn in 31 s."""

DRIVE_TIME = 1.5
"""How long it is driven, s."""

SILENT_TIME = 1.0
"""How long it then gets nothing, s: twice as long as bases should wait."""

SEND_INTERVAL = 0.1
"""Between two velocities, s, as in a run."""

ODOMETRY_TIMEOUT = 5.0
"""For the base's odometry to come, s."""

STILL_ANGULAR, STILL_LINEAR = 0.02, 0.01
"""Below these it stands, rad/s and m/s: odometry is never quite zero."""

MAX_ODOMETRY_AGE = 0.3
"""Older odometry at the end of the silence does not count, s."""

FINAL_ZEROS = 5
"""Zero velocities at the end: a message may be lost."""


@dataclass(frozen=True)
class MeasuredMotion:
    """An odometry: when it came, on the monotonic clock, s; m/s; rad/s."""

    when: float
    linear: float
    angular: float

    @property
    def is_still(self) -> bool:
        """Whether the base stands."""
        return abs(self.angular) < STILL_ANGULAR and abs(self.linear) < STILL_LINEAR


@dataclass(frozen=True)
class Obstacle:
    """Why a base must not be driven, and what to do."""

    problem: str
    remedy: str


NO_ODOMETRY = Obstacle(
    "no odometry comes", "start the base's driver, or name its topic with --odom"
)


def motion_of(newest: tuple[float, Any] | None) -> MeasuredMotion | None:
    """Return the motion of a `nav_msgs/Odometry` and when it came; None if none came."""
    if newest is None:
        return None
    when, odometry = newest
    speed = odometry.twist.twist
    return MeasuredMotion(when, speed.linear.x, speed.angular.z)


def senders_obstacle(topic: str, others: Set[str]) -> Obstacle | None:
    """Return why a base must not be driven that others drive; None if there are none."""
    if not others:
        return None
    names = " and ".join(sorted(others))
    return Obstacle(f"velocities on {topic} come from {names} too", "end it first")


class Base(Protocol):
    """A base that is really there."""

    def send(self, linear: float, angular: float) -> None:
        """Send a velocity once, m/s and rad/s."""

    def motion(self) -> MeasuredMotion | None:
        """The newest odometry; None if there was none yet."""

    def obstacle(self) -> Obstacle | None:
        """Return why it must not be driven now; None if it may be."""


def check_stop(base: Base) -> Finding:
    """Turn a base on the spot, for two and a half seconds at most, and fall silent.

    Raises:
        SystemExit: a signal came; the base has been sent zero.
    """
    ended: SimpleQueue[None] = SimpleQueue()

    def pause(seconds: float) -> None:
        with suppress(queue.Empty):
            ended.get(timeout=seconds)
            raise SystemExit(signals.exit_code())

    driven = []

    def send(angular: float) -> None:
        driven.append(angular)
        base.send(0.0, angular)

    with (
        zero_at_the_end(lambda: _send_zeros(base) if driven else None),
        signals.defer_signals(lambda: ended.put(None)),
    ):
        return _try(base, send, pause)


def _try(base: Base, send: Callable[[float], None], pause: Callable[[float], None]) -> Finding:
    until = time.monotonic() + ODOMETRY_TIMEOUT
    while (obstacle := base.obstacle() or _missing_odometry(base)) and time.monotonic() < until:
        pause(SEND_INTERVAL)
    if obstacle:
        return _not_ok(obstacle.problem, obstacle.remedy)
    if not _turns(base, send, pause):
        return _not_ok(
            "the odometry shows no motion, so that nobody knows",
            "switch its motors on, and look at `cmd_vel` in voz.toml and at --odom",
        )
    return _judge(*_stay_silent(base, pause))


def _missing_odometry(base: Base) -> Obstacle | None:
    return None if base.motion() else NO_ODOMETRY


def _turns(base: Base, send: Callable[[float], None], pause: Callable[[float], None]) -> bool:
    """Drive it; returns whether it moved."""
    moved = False
    for _ in range(round(DRIVE_TIME / SEND_INTERVAL)):
        send(TURN_SPEED)
        pause(SEND_INTERVAL)
        motion = base.motion()
        moved = moved or (motion is not None and abs(motion.angular) > TURN_SPEED / 4)
    return moved


def _stay_silent(base: Base, pause: Callable[[float], None]) -> tuple[float, list[MeasuredMotion]]:
    """Send nothing; returns when that began, and all odometry from then on."""
    begun = time.monotonic()
    motions: list[MeasuredMotion] = []
    while time.monotonic() - begun < SILENT_TIME:
        pause(SEND_INTERVAL / 5)
        motion = base.motion()
        if motion and motion.when > begun and motion not in motions[-1:]:
            motions.append(motion)
    return begun, motions


def _judge(begun: float, motions: list[MeasuredMotion]) -> Finding:
    if not motions or motions[-1].when < begun + SILENT_TIME - MAX_ODOMETRY_AGE:
        return _not_ok(
            "its odometry fell silent too, so that nobody knows",
            "let it come ten times a second or more, also while no velocity comes",
        )
    if not motions[-1].is_still:
        return _not_ok(
            f"it drives on at {motions[-1].angular:.2f} rad/s, {SILENT_TIME:g} s after the last "
            "velocity",
            "put examples/base_watchdog_ros1.py or _ros2.py between voz and the base",
        )
    moving = [motion.when for motion in motions if not motion.is_still]
    took = max(moving, default=begun) - begun
    return Finding(BASE_STOPS, True, f"it stood {took:.1f} s after the last velocity")


def _not_ok(problem: str, remedy: str) -> Finding:
    return Finding(BASE_STOPS, False, problem, remedy)


def _send_zeros(base: Base) -> None:
    for _ in range(FINAL_ZEROS):
        with suppress(RobotError):
            base.send(0.0, 0.0)
        time.sleep(SEND_INTERVAL)
