"""The robot's command rules: a pure state machine with no I/O and no clock.

`RULES` is the command table of docs/commands.md, line by line. These are the bare rules of the
original program; `voz.control.safety` stands between them and a robot that runs away.
"""

from __future__ import annotations

import enum
from collections.abc import Callable, Mapping
from typing import NamedTuple

import msgspec
from msgspec.structs import replace

STEPS_PER_UNIT = 20
"""Velocities are counted in whole steps of 1/20 m/s and rad/s: 0.05 leaves no float residue."""

ONCE = 1
"""The step of `speed up` and `slow down`: 0.05 m/s or rad/s."""

TWICE = 2
"""The step of every other command: 0.1 m/s or rad/s."""


class Mode(enum.Enum):
    """Whether the last change of direction was a turn on the way or a rotation on the spot."""

    NONE = "none"
    TURNING = "turning"
    ROTATING = "rotating"


class State(msgspec.Struct, frozen=True):
    """What the controller knows between two commands.

    Attributes:
        listening: whether commands are obeyed.
        linear: forward velocity in steps of 0.05 m/s.
        angular: turning velocity to the left in steps of 0.05 rad/s.
        mode: turning, rotating or neither.
    """

    listening: bool = False
    linear: int = 0
    angular: int = 0
    mode: Mode = Mode.NONE

    @property
    def moving(self) -> bool:
        """Whether any velocity is not 0."""
        return bool(self.linear or self.angular)

    def velocities(self) -> tuple[float, float]:
        """The linear (m/s) and angular (rad/s) velocity, exact multiples of 0.05."""
        return self.linear / STEPS_PER_UNIT, self.angular / STEPS_PER_UNIT


class Outcome(NamedTuple):
    """What one command did: the new state, and what goes out once because of it.

    `obeyed` is False for a command that was ignored, as all but one are while not listening.
    """

    state: State
    selected_object: int | None = None
    reply: str | None = None
    obeyed: bool = True


def halt(state: State) -> State:
    """Both velocities 0; the mode stays."""
    return replace(state, linear=0, angular=0)


def go(state: State, linear: int) -> State:
    """Drive straight with a new linear velocity."""
    return replace(state, linear=linear, angular=0)


def turn(state: State, side: int) -> State:
    """Turn to a side (1 left, -1 right) while driving on; a turn to that side gets tighter."""
    if state.angular * side <= 0 or state.mode is Mode.ROTATING:
        return replace(state, angular=TWICE * side, mode=Mode.TURNING)
    return replace(state, angular=state.angular + TWICE * side)


def rotate(state: State, side: int) -> State:
    """Rotate on the spot to a side (1 left, -1 right)."""
    if state.angular * side <= 0 or state.mode is Mode.TURNING:
        return replace(state, linear=0, angular=TWICE * side, mode=Mode.ROTATING)
    return replace(state, linear=0)


def speed_up(state: State) -> State:
    """Move the velocity in use 0.05 away from 0."""
    if state.linear:
        return replace(state, linear=state.linear + (ONCE if state.linear > 0 else -ONCE))
    if state.mode is Mode.ROTATING:
        return replace(state, angular=state.angular + (ONCE if state.angular > 0 else -ONCE))
    return state


def slow_down(state: State) -> State:
    """Move the velocity in use 0.05 towards 0, and from 0 on to the other side."""
    if state.linear:
        return replace(state, linear=state.linear - (ONCE if state.linear > 0 else -ONCE))
    if state.mode is Mode.ROTATING:
        return replace(state, angular=state.angular - (ONCE if state.angular > 0 else -ONCE))
    return state


RULES: Mapping[str, Callable[[State], State]] = {
    "stop": halt,
    "go forward": lambda state: go(state, TWICE),
    "go back": lambda state: go(state, -TWICE),
    "turn left": lambda state: turn(state, 1),
    "turn right": lambda state: turn(state, -1),
    "rotate left": lambda state: rotate(state, 1),
    "rotate right": lambda state: rotate(state, -1),
    "speed up": speed_up,
    "slow down": slow_down,
}
"""What each motion command does while listening."""

OBJECTS: Mapping[str, int] = {"point beer": 1, "point cocacola": 2, "fold arm": 100}
"""What each object command publishes on `selected_object` while listening."""

COMMANDS = (*RULES, *OBJECTS, "start speech", "stop speech")
"""All that it knows: the list that comes with voz, in another order."""

STARTED = "bep bep. I am listening you"
STOPPED = "bep bep. I stop listening"
REPLIES = (STARTED, STOPPED)


def obey(state: State, command: str) -> Outcome:
    """Apply one command by the bare rules.

    Args:
        state: the state before it.
        command: a sentence in lower case; one that has no rule changes nothing.

    Returns:
        The state after it, the object to select and the reply to say, if any, and whether it was
        obeyed.
    """
    if command == "start speech":
        return Outcome(replace(state, listening=True), reply=None if state.listening else STARTED)
    if not state.listening:
        return Outcome(state, obeyed=False)
    if command == "stop speech":
        return Outcome(replace(state, listening=False), reply=STOPPED)
    if command in RULES:
        return Outcome(RULES[command](state))
    return Outcome(state, selected_object=OBJECTS.get(command))
