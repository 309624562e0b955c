"""What the command rules alone would let go wrong (the safety table of the README).

S1 to S4 look at one command: the state before it and the state the bare rules gave. S6 looks at
the time since the last command, S7 at the end of the program. S5 (hearing is lost) belongs to the
live microphone.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from contextlib import contextmanager

from msgspec.structs import replace

from voz.config import Safety
from voz.control.controller import STEPS_PER_UNIT, Outcome, State, halt, obey
from voz.events import Event, Utterance, Warning

STOP, STOP_SPEECH = "stop", "stop speech"

STOPPING = (STOP, STOP_SPEECH)
"""What stops the robot whatever its state: it overtakes all that waits."""


def stop_always_works(command: str, after: State) -> State:
    """S1: `stop` works always, listening or not."""
    return halt(after) if command == STOP else after


def stop_speech_stops(command: str, after: State) -> State:
    """S2: `stop speech` also stops the robot: nobody could stop it afterwards."""
    return halt(after) if command == STOP_SPEECH else after


def slow_down_ends_at_zero(command: str, before: State, after: State) -> State:
    """S3: `slow down` never starts a motion or turns it round."""
    if command != "slow down":
        return after
    return replace(
        after,
        linear=_between_zero_and(before.linear, after.linear),
        angular=_between_zero_and(before.angular, after.angular),
    )


def limited(after: State, max_linear: float, max_angular: float) -> State:
    """S4: velocities stay within their limits, in m/s and rad/s."""
    linear, angular = _whole_steps(max_linear), _whole_steps(max_angular)
    return replace(
        after,
        linear=max(-linear, min(after.linear, linear)),
        angular=max(-angular, min(after.angular, angular)),
    )


def obey_safely(state: State, command: str, safety: Safety) -> Outcome:
    """Apply one command by the rules of `obey`, then by S1 to S4.

    Args:
        state: the state before it.
        command: a sentence in lower case.
        safety: the limits; with `enabled` False this is `obey` itself.

    Returns:
        The state after it, the object to select and the reply to say, if any, and whether it was
        obeyed.
    """
    outcome = obey(state, command)
    if not safety.enabled:
        return outcome
    after = stop_always_works(command, outcome.state)
    after = stop_speech_stops(command, after)
    after = slow_down_ends_at_zero(command, state, after)
    after = limited(after, safety.max_linear, safety.max_angular)
    return outcome._replace(state=after, obeyed=outcome.obeyed or command in STOPPING)


def motion_has_expired(state: State, silence: float, safety: Safety) -> bool:
    """S6: whether the robot has moved for too long since the last command.

    Args:
        state: the state now.
        silence: time since the last command was obeyed, s.
        safety: its `motion_time_limit` is the limit; 0 is none.
    """
    limit = safety.motion_time_limit
    return safety.enabled and limit > 0 and state.moving and silence >= limit


def ends_goals(event: Event) -> bool:
    """Whether goals are to be cancelled by which others drive the robot, as zero does not end them.

    They are at a command that stops it, and wherever it stops because nobody could tell it to.
    """
    if isinstance(event, Utterance):
        return event.obeyed is True and event.text in STOPPING
    return isinstance(event, Warning) and event.stops


@contextmanager
def zero_at_the_end(publish_zero: Callable[[], None]) -> Iterator[None]:
    """S7: whatever ends the block, an error or a signal too, zero velocity is published last."""
    try:
        yield
    finally:
        publish_zero()


def _between_zero_and(before: int, after: int) -> int:
    return max(min(0, before), min(after, max(0, before)))


def _whole_steps(velocity: float) -> int:
    return int(velocity * STEPS_PER_UNIT)
