"""What an obeyed command does to the robot: a pure state machine, with time as an argument.

The table of commands (`voz.control.table`) says what each does, the motion's own rules are in
`voz.control.motion`, and `voz.control.safety` stands between them and a robot that runs away.
"""

from __future__ import annotations

from collections.abc import Mapping
from types import MappingProxyType
from typing import NamedTuple, TypeAlias

import msgspec
from msgspec.structs import replace

from voz.control.bounded_motion import Bound, Place, begun, gone_on, reached
from voz.control.motion import Motion, halt, moved
from voz.control.safety import secured
from voz.control.steps import Step, filled
from voz.control.table import USUAL, CommandTable, Steps, is_selection
from voz.errors import ConfigError
from voz.events import Call, Event, Ignored, Play, Publish, Reply, Run, SelectedObject, Warning
from voz.settings import Safety

ANSWER_TIME = 10.0
"""How long an answer is waited for, s."""

Slots: TypeAlias = Mapping[str, str | float]

NO_SLOTS: Slots = MappingProxyType({})


class GivenCommand(NamedTuple):
    """What was said: the command's name, what its slots hold, and when, s."""

    name: str
    slots: Slots = NO_SLOTS
    t: float = 0.0


class PendingCommand(msgspec.Struct, frozen=True):
    """A command that waits for a yes: what it would do, and until when, s."""

    name: str
    steps: Steps
    until: float


class State(msgspec.Struct, frozen=True):
    """What the controller knows between two commands.

    Attributes:
        listening: whether commands are obeyed.
        motion: the velocities.
        commands: the set of commands in use, of the table.
        bound: the motion under way, if it ends by itself.
        to_do: the steps after it.
        asked: what waits for a yes.
        last_moved: the steps of the last command that moved the robot.
    """

    listening: bool = False
    motion: Motion = Motion()
    commands: str = USUAL
    bound: Bound | None = None
    to_do: Steps = ()
    asked: PendingCommand | None = None
    last_moved: Steps = ()

    @property
    def moving(self) -> bool:
        """Whether any velocity is not 0, or will not be without another command."""
        return self.motion.moving or bool(self.to_do)


class Transition(NamedTuple):
    """What a command or the time did.

    Attributes:
        state: the state after it.
        events: what goes out once because of it.
        obeyed: False for a command that was ignored.
        ignored: why it was.
    """

    state: State
    events: tuple[Event, ...] = ()
    obeyed: bool = True
    ignored: Ignored | None = None


def at_rest(state: State) -> State:
    """Both velocities 0, and nothing is to follow; the listening stays."""
    return replace(state, motion=halt(state.motion), bound=None, to_do=(), asked=None)


def obey(
    state: State,
    command: GivenCommand,
    table: CommandTable,
    safety: Safety,
    place: Place | None = None,
) -> Transition:
    """Apply one command.

    Args:
        state: the state before it.
        command: one that has no line in the table changes nothing.
        table: what each command does.
        safety: the limits; with `enabled` False the bare rules.
        place: where odometry has the robot.

    Returns:
        The state after it, and what goes out.
    """
    name = command.name
    steps = table.steps(name, state.commands)
    if not state.listening and name not in table.starts:
        if safety.enabled and name in table.halts:  # S1, S2
            return Transition(at_rest(state))
        return Transition(state, obeyed=False, ignored="not_listening")
    if steps is None and state.commands != USUAL:
        return Transition(state, obeyed=False, ignored="not_now")
    try:
        steps = tuple(filled(step, command.slots) for step in steps or ())
    except ConfigError as error:
        return _refused(state, command, str(error))
    if steps and steps[0].confirm:
        return _ask(state, command, steps)
    return _do(state, command, steps, safety, place)


def go_on(state: State, t: float, safety: Safety, place: Place | None = None) -> Transition:
    """Let time pass: a bounded motion ends, what follows begins, a question expires.

    Args:
        state: the state before it.
        t: the time, s.
        safety: the limits.
        place: where odometry has the robot.
    """
    if state.asked and t > state.asked.until:
        told = Warning(t, f'no answer: "{state.asked.name}" is not done')
        return Transition(replace(state, asked=None), (told,))
    if state.bound is None:
        return Transition(state)
    bound = gone_on(state.bound, state.motion, t, place)
    if not reached(bound, state.motion):
        return Transition(replace(state, bound=bound))
    rested = replace(state, motion=halt(state.motion), bound=None, to_do=())
    return _take(rested, state.to_do, t, safety, place)


def _do(
    state: State, command: GivenCommand, steps: Steps, safety: Safety, place: Place | None
) -> Transition:
    """Take the steps of a command that is obeyed."""
    first = steps[0] if steps else None
    if first and first.answer is not None:
        return _answer(state, command, first, safety, place)
    state = replace(state, asked=None)
    if first and first.again:
        if not state.last_moved:
            return _refused(state, command, "nothing has moved yet")
        steps = (*state.last_moved, *steps[1:])
    if any(step.moves for step in steps):
        state = replace(state, last_moved=steps)
    if any(step.stop or step.drives for step in steps):
        state = _without_bound(state)
    return _take(state, steps, command.t, safety, place)


def _without_bound(state: State) -> State:
    """End a motion that would have ended by itself: it must not go on for ever as another's."""
    if state.bound is None:
        return state
    return replace(state, motion=halt(state.motion), bound=None, to_do=())


def _take(state: State, steps: Steps, t: float, safety: Safety, place: Place | None) -> Transition:
    """Take steps one after the other, up to a motion that ends by itself."""
    events: list[Event] = []
    for number, step in enumerate(steps):
        before = state
        motion = secured(step, before.motion, moved(before.motion, step), safety)
        state = replace(state, motion=motion, **_changed(step))
        if before.motion.moving and not motion.moving:
            state = at_rest(state)  # whatever ended it: nothing is to begin another by itself
        if step.listen is None or state.listening != before.listening:
            events += _events(step, t)
        if step.bounded:
            left = steps[number + 1 :]
            return Transition(
                replace(state, bound=begun(step, t, place), to_do=left), tuple(events)
            )
    return Transition(state, tuple(events))


def _changed(step: Step) -> dict[str, object]:
    """What a step says of the state besides the velocities."""
    changed: dict[str, object] = {}
    if step.listen is not None:
        changed["listening"] = step.listen
    if step.listen is False:
        changed["commands"] = USUAL
    if step.state is not None:
        changed["commands"] = step.state
    return changed


def _events(step: Step, t: float) -> list[Event]:
    """What goes out because of a step."""
    events: list[Event] = []
    if is_selection(step) and isinstance(step.publish, int):
        events.append(SelectedObject(t, step.publish))
    elif step.publish is not None and step.topic is not None:
        events.append(Publish(t, step.topic, step.publish))
    seconds = None if step.seconds is None else float(step.seconds)
    if step.run:
        events.append(Run(t, step.run, seconds))
    if step.call:
        function, *arguments = step.call
        events.append(Call(t, str(function), tuple(arguments), seconds))
    if step.play:
        events.append(Play(t, step.play))
    if step.say:
        events.append(Reply(t, step.say))
    return events


def _ask(state: State, command: GivenCommand, steps: Steps) -> Transition:
    """Ask before anything is done; another command before the answer takes it back."""
    question = steps[0].confirm
    said = question if isinstance(question, str) else f"{command.name}?"
    sure = (replace(steps[0], confirm=False), *steps[1:])
    asked = PendingCommand(command.name, sure, command.t + ANSWER_TIME)
    return Transition(replace(state, asked=asked), (Reply(command.t, said),))


def _answer(
    state: State, command: GivenCommand, answer: Step, safety: Safety, place: Place | None
) -> Transition:
    """Do what was asked, or leave it."""
    asked = state.asked
    if asked is None or command.t > asked.until:
        return Transition(replace(state, asked=None), obeyed=False, ignored="nothing_asked")
    state = replace(state, asked=None)
    said = _events(answer, command.t)
    if not answer.answer:
        return Transition(state, tuple(said))
    done = _do(state, GivenCommand(asked.name, NO_SLOTS, command.t), asked.steps, safety, place)
    return done._replace(events=(*said, *done.events))


def _refused(state: State, command: GivenCommand, why: str) -> Transition:
    told = Warning(command.t, f'"{command.name}" cannot be done: {why}')
    return Transition(state, (told,), obeyed=False)
