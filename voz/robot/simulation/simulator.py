"""A simulated robot, which remembers its way through a room."""

from __future__ import annotations

from collections import deque
from collections.abc import Callable
from typing import NamedTuple

import msgspec
from msgspec.structs import replace

from voz.control.motion import Place
from voz.events import Event, Notice, SelectedObject, Twist, Utterance
from voz.robot.base import Robot
from voz.robot.simulation.world import WorldState, gap, start, step
from voz.settings import Simulator

TIME_STEP = 0.01
"""The time step, s; constant, so that a run can be repeated exactly."""

STEPS_PER_STATE = 5
"""Steps between two states that are kept: 20 states a second."""

MAX_KEPT_STATES = 72_000
"""States (and commands) that are kept, an hour of motion; then the oldest are dropped."""


class TripMark(NamedTuple):
    """Something that happened on the way: when (s), where (m), and what was said or hit."""

    t: float
    x: float
    y: float
    text: str


class Trip(msgspec.Struct, frozen=True):
    """What a simulated robot did; pictures are drawn from it.

    `states` has the start, each change and the present; `said` the commands that were obeyed.
    """

    settings: Simulator
    states: tuple[WorldState, ...]
    said: tuple[TripMark, ...] = ()
    collisions: tuple[TripMark, ...] = ()


class SimulatedRobot(Robot):
    """Follows the events through the room, in the time of the events."""

    def __init__(
        self, settings: Simulator, warn: Callable[[Notice], None] = lambda _: None
    ) -> None:
        """Put the robot into its room; `receive` calls `warn` once for each collision."""
        self._settings = settings
        self._warn = warn
        self._now = start(settings), Twist(0.0, 0.0, 0.0)
        self._steps = 0
        self._states: deque[WorldState] = deque([self._now[0]], MAX_KEPT_STATES)
        self._said: deque[TripMark] = deque(maxlen=MAX_KEPT_STATES)
        self._collisions: deque[TripMark] = deque(maxlen=MAX_KEPT_STATES)

    def receive(self, event: Event) -> None:
        """Let the time until the event pass, then follow it."""
        self._advance(event.t)
        state, twist = self._now
        if isinstance(event, Twist):
            self._now = state, event
        elif isinstance(event, SelectedObject):
            self._now = replace(state, selected=event.value), twist
        elif isinstance(event, Utterance) and event.obeyed:
            self._said.append(TripMark(event.t, state.pose.x, state.pose.y, event.text))

    def state_at(self, t: float) -> WorldState:
        """Return the state at a time, s, if nothing more comes until then."""
        state, twist = self._now
        while state.t < t - TIME_STEP / 2:
            following = step(state, twist, TIME_STEP, self._settings)
            if _is_same(state, following):
                return replace(state, t=t)
            state = following
        return state

    def place(self, t: float) -> Place | None:
        """Return where it is at a time, s."""
        return self.state_at(t).pose

    def come_to_rest(self) -> None:
        """Let time pass until nothing moves any more."""
        while self._step():
            pass

    def trip(self) -> Trip:
        """Return what happened so far."""
        now, states = self._now[0], tuple(self._states)
        if states[-1] != now:
            states = (*states, now)
        return Trip(self._settings, states, tuple(self._said), tuple(self._collisions))

    def _advance(self, t: float) -> None:
        while self._now[0].t < t - TIME_STEP / 2:
            if not self._step():
                # Nothing will happen until then, however long it is.
                state, twist = self._now
                self._now = replace(state, t=round(t / TIME_STEP) * TIME_STEP), twist
                return

    def _step(self) -> bool:
        """Advance by one time step; return whether anything changed."""
        before, twist = self._now
        state = step(before, twist, TIME_STEP, self._settings)
        if _is_same(before, state):
            if not _is_same(before, self._states[-1]):
                self._states.append(before)
            return False
        self._now = state, twist
        self._steps += 1
        if self._steps % STEPS_PER_STATE == 0:
            self._states.append(state)
        if state.collided and not before.collided:
            self._collide(state)
        return True

    def _collide(self, state: WorldState) -> None:
        hit, pose = gap(state.pose, self._settings).to, state.pose
        self._collisions.append(TripMark(round(state.t, 3), pose.x, pose.y, hit))
        where = f"x {pose.x:.2f} m, y {pose.y:.2f} m"
        text = f"the robot hit {hit} at {where} and stopped: drive it away or rotate it"
        self._warn(Notice(round(state.t, 3), text))


def _is_same(before: WorldState, after: WorldState) -> bool:
    return replace(after, t=before.t) == before
