"""How far a motion has come that is to end by itself. Pure: times and places come in."""

from __future__ import annotations

import math
from typing import TypeAlias

import msgspec
from msgspec.structs import replace

from voz.control.motion import Motion
from voz.control.steps import Step

Place: TypeAlias = tuple[float, float, float]
"""Where odometry has a robot: x and y, m, and its heading, rad."""

BY_TIME = 1.5
"""Where odometry tells how far it came, it may take so many times longer than by the velocity.

A base takes time to get going, and slips; odometry that stands still must not drive it for ever.
"""

HALF_A_BEAT = 0.05
"""It ends with the beat that is nearest to the end, s."""


class Bound(msgspec.Struct, frozen=True):
    """A motion that is under way, and where it ends.

    Attributes:
        t: when it was looked at last, s.
        until: when it ends, s; None if it ends by its way alone.
        metres: how far it drives; None if it turns or ends by time alone.
        radians: how far it turns.
        timed: how far it came by its velocity and the time, m or rad.
        origin: where odometry had the robot first; None without any.
        heading: what odometry had last, rad.
        turned: how far it turned by odometry, rad.
        driven: how far it drove by odometry, m.
    """

    t: float
    until: float | None = None
    metres: float | None = None
    radians: float | None = None
    timed: float = 0.0
    origin: Place | None = None
    heading: float = 0.0
    turned: float = 0.0
    driven: float = 0.0


def begun(step: Step, t: float, place: Place | None) -> Bound:
    """Begin a motion that is bounded.

    Args:
        step: its amounts are numbers.
        t: the time, s.
        place: where odometry has the robot.
    """
    seconds, metres, degrees = (_number(x) for x in (step.seconds, step.metres, step.degrees))
    return Bound(
        t,
        None if seconds is None else t + seconds,
        metres,
        None if degrees is None else math.radians(degrees),
        origin=place,
        heading=place[2] if place else 0.0,
    )


def gone_on(bound: Bound, motion: Motion, t: float, place: Place | None) -> Bound:
    """Note how far it came since.

    Args:
        bound: what was known before.
        motion: the velocities that the robot was asked to hold meanwhile.
        t: the time, s.
        place: where odometry has the robot.
    """
    timed = bound.timed + _speed(bound, motion) * (t - bound.t)
    if place is None or bound.origin is None:
        return replace(bound, t=t, timed=timed, origin=None)
    return replace(
        bound,
        t=t,
        timed=timed,
        heading=place[2],
        turned=bound.turned + math.remainder(place[2] - bound.heading, math.tau),
        driven=math.dist(place[:2], bound.origin[:2]),
    )


def reached(bound: Bound, motion: Motion) -> bool:
    """Tell whether the motion is at its end."""
    near = HALF_A_BEAT
    if bound.until is not None and bound.t + near > bound.until:
        return True
    way = bound.metres if bound.radians is None else bound.radians
    if way is None:
        return False
    measured = bound.driven if bound.radians is None else abs(bound.turned)
    longest = way if bound.origin is None else way * BY_TIME
    near *= _speed(bound, motion)
    return bound.timed + near > longest or (bound.origin is not None and measured + near > way)


def _speed(bound: Bound, motion: Motion) -> float:
    """How fast it nears its end, m/s or rad/s."""
    linear, angular = motion.velocities()
    return abs(linear) if bound.radians is None else abs(angular)


def _number(amount: float | str | None) -> float | None:
    return None if amount is None else float(amount)
