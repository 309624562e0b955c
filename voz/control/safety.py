"""The safety rules of docs/safety.md: S2 to S4, S6 and S7.

S1 is in `voz.control.state_machine`, S5 in `voz.control.controller`. `voz.control.table` checks
that a table of commands can stop the robot.
"""

from __future__ import annotations

from collections.abc import Callable, Collection, Iterator
from contextlib import contextmanager

from msgspec.structs import replace

from voz.control.motion import Motion, halt
from voz.control.steps import PER_UNIT, Step
from voz.events import Event, Notice, Utterance
from voz.settings import Safety

UNWATCHED_MOTION_LIMIT = 5.0
"""How long a motion without an end of its own may last that somebody asked for who does not watch
the robot, s: half a metre at the velocity of `go forward`."""


def apply_safety(step: Step, before: Motion, after: Motion, safety: Safety) -> Motion:
    """Apply S2, S3 and S4 to a change of the velocities by the bare rules."""
    if not safety.enabled:
        return after
    after = stop_listening_stops(step, after)
    after = slower_ends_at_zero(step, before, after)
    return limit_velocities(after, safety.max_linear, safety.max_angular)


def stop_listening_stops(step: Step, after: Motion) -> Motion:
    """S2: ending the listening also stops the robot, as no command could afterward."""
    return halt(after) if step.listen is False else after


def slower_ends_at_zero(step: Step, before: Motion, after: Motion) -> Motion:
    """S3: `slow down` never starts a motion or reverses it."""
    if step.slower is None:
        return after
    return replace(
        after,
        linear=_between_zero_and(before.linear, after.linear),
        angular=_between_zero_and(before.angular, after.angular),
    )


def limit_velocities(after: Motion, max_linear: float, max_angular: float) -> Motion:
    """S4: velocities stay within their limits, in m/s and rad/s."""
    linear, angular = _thousandths(max_linear), _thousandths(max_angular)
    return replace(
        after,
        linear=max(-linear, min(after.linear, linear)),
        angular=max(-angular, min(after.angular, angular)),
    )


def motion_has_expired(moving: bool, silence: float, safety: Safety) -> bool:
    """S6: whether the robot moves though the last command was `silence` s ago."""
    limit = safety.motion_time_limit
    return safety.enabled and limit > 0 and moving and silence >= limit


def ends_goals(event: Event, halts: Collection[str]) -> bool:
    """Whether an event cancels the goals of other programs, which zero velocity does not end.

    Commands in `halts` cancel them, and warnings for which the robot stops.
    """
    if isinstance(event, Utterance):
        return event.obeyed is True and event.name in halts
    return isinstance(event, Notice) and event.stops


@contextmanager
def zero_at_the_end(publish_zero: Callable[[], None]) -> Iterator[None]:
    """S7: publish zero velocity last, whatever ends the block: an error or a signal, too."""
    try:
        yield
    finally:
        publish_zero()


def _between_zero_and(before: int, after: int) -> int:
    return max(min(0, before), min(after, max(0, before)))


def _thousandths(velocity: float) -> int:
    return int(round(velocity * PER_UNIT, 6))
