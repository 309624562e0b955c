"""Whether a base stops by itself when no velocity comes any more, as its odometry tells.

It turns on the spot, which takes no room, and then hears nothing for a second. Whatever ends this,
zero velocity is what it hears last.
"""

from __future__ import annotations

import queue
import time
from collections.abc import Callable
from contextlib import suppress
from queue import SimpleQueue
from typing import Any, NamedTuple, Protocol

from voz.apps.doctor.finding import Finding
from voz.control.safety import zero_at_the_end
from voz.errors import RobotError
from voz.process import signals

NAME = "base stops"

TURN = 0.2
"""How fast it turns, rad/s: slower, and the friction holds some bases; 1 turn in 31 s."""

DRIVEN = 1.5
"""How long it is driven, s."""

SILENCE = 1.0
"""How long it then hears nothing, s: twice as long as bases should wait."""

BEAT = 0.1
"""From one velocity to the next, s, as in a run."""

FOUND = 5.0
"""How long the base's odometry is waited for, s."""

STILL, STILL_LINEAR = 0.02, 0.01
"""Below these it stands, rad/s and m/s: odometry is never quite still."""

FRESH = 0.3
"""An odometry that is older at the end of the silence tells nothing, s."""

LAST_ZEROS = 5
"""So often zero is sent at the end: a message may be lost."""


class MeasuredMotion(NamedTuple):
    """What an odometry told: when it came, by the monotonic clock, s; m/s; rad/s."""

    when: float
    linear: float
    angular: float

    @property
    def still(self) -> bool:
        """Whether the base stands."""
        return abs(self.angular) < STILL and abs(self.linear) < STILL_LINEAR


def told_motion(newest: tuple[float, Any] | None) -> MeasuredMotion | None:
    """Take from a `nav_msgs/Odometry`, and when it came, how the base moves; None if none came."""
    if newest is None:
        return None
    when, odometry = newest
    speed = odometry.twist.twist
    return MeasuredMotion(when, speed.linear.x, speed.angular.z)


class Base(Protocol):
    """A base that is really there."""

    def send(self, linear: float, angular: float) -> None:
        """Send a velocity once, m/s and rad/s."""

    def motion(self) -> MeasuredMotion | None:
        """The newest odometry; None if there was none yet."""

    def obstacle(self) -> str | None:
        """Why it must not be driven now, and behind a semicolon what to do; None if it may be."""


def base_stops(base: Base) -> Finding:
    """Drive a base and fall silent; a signal ends it at once.

    Args:
        base: turns on the spot, for two and a half seconds at most.

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
        zero_at_the_end(lambda: _rest(base) if driven else None),
        signals.defer_signals(lambda: ended.put(None)),
    ):
        return _try(base, send, pause)


def _try(base: Base, send: Callable[[float], None], pause: Callable[[float], None]) -> Finding:
    until = time.monotonic() + FOUND
    while (obstacle := base.obstacle() or _no_odometry(base)) and time.monotonic() < until:
        pause(BEAT)
    if obstacle:
        return _bad(*obstacle.split("; ", 1))
    if not _turns(base, send, pause):
        return _bad(
            "the odometry tells of no motion, so that nobody knows",
            "switch its motors on, and look at `cmd_vel` in voz.toml and at --odom",
        )
    return _judged(*_silent(base, pause))


def _no_odometry(base: Base) -> str | None:
    lacking = "no odometry comes; start the base's driver, or name its topic with --odom"
    return None if base.motion() else lacking


def _turns(base: Base, send: Callable[[float], None], pause: Callable[[float], None]) -> bool:
    """Drive it; tell whether it moved."""
    moved = False
    for _ in range(round(DRIVEN / BEAT)):
        send(TURN)
        pause(BEAT)
        motion = base.motion()
        moved = moved or (motion is not None and abs(motion.angular) > TURN / 4)
    return moved


def _silent(base: Base, pause: Callable[[float], None]) -> tuple[float, list[MeasuredMotion]]:
    """Send nothing; gives when that began, and all odometry from then on."""
    begun = time.monotonic()
    told: list[MeasuredMotion] = []
    while time.monotonic() - begun < SILENCE:
        pause(BEAT / 5)
        motion = base.motion()
        if motion and motion.when > begun and motion not in told[-1:]:
            told.append(motion)
    return begun, told


def _judged(begun: float, told: list[MeasuredMotion]) -> Finding:
    """Tell from a silence whether the base stopped in it."""
    if not told or told[-1].when < begun + SILENCE - FRESH:
        return _bad(
            "its odometry fell silent too, so that nobody knows",
            "let it come ten times a second or more, also while no velocity comes",
        )
    if not told[-1].still:
        return _bad(
            f"it drives on at {told[-1].angular:.2f} rad/s, {SILENCE:g} s after the last velocity",
            "put examples/base_watchdog_ros1.py or _ros2.py between voz and the base",
        )
    moving = [motion.when for motion in told if not motion.still]
    took = max(moving, default=begun) - begun
    return Finding(NAME, True, f"it stood {took:.1f} s after the last velocity")


def _bad(told: str, to_do: str) -> Finding:
    return Finding(NAME, False, told, to_do)


def _rest(base: Base) -> None:
    for _ in range(LAST_ZEROS):
        with suppress(RobotError):
            base.send(0.0, 0.0)
        time.sleep(BEAT)
