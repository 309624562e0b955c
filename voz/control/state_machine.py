"""What an obeyed command does to the robot: a pure state machine, with time as an argument.

`voz.control.table` has what each command does, `voz.control.motion` how it changes velocities.
"""

from __future__ import annotations

import dataclasses
from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import NamedTuple, TypeAlias

import msgspec
from msgspec.structs import replace

from voz.control.motion import (
    BoundedMotion,
    Motion,
    Place,
    apply_step,
    begin_bounded,
    halt,
    is_finished,
    update_bounded,
)
from voz.control.safety import apply_safety
from voz.control.steps import Step, fill_slots
from voz.control.table import DEFAULT_STATE, CommandTable, Steps, is_selection
from voz.errors import ConfigError
from voz.events import (
    CallFunction,
    Event,
    Ignored,
    Notice,
    Play,
    Publish,
    Reply,
    SelectedObject,
    StartProgram,
)
from voz.settings import Safety

ANSWER_TIMEOUT = 10.0
"""An unanswered question expires after this time, s."""

Slots: TypeAlias = Mapping[str, str | float]


@dataclass(frozen=True, slots=True)
class GivenCommand:
    """A command, what was said in its slots, when, s, and the whole sentence."""

    name: str
    slots: Slots = field(default_factory=dict)
    t: float = 0.0
    text: str = ""


class PendingCommand(msgspec.Struct, frozen=True):
    """A command that waits for a yes until a time, s; its first step says that it asks."""

    command: GivenCommand
    steps: Steps
    until: float


class State(msgspec.Struct, frozen=True):
    """The robot's state between two commands."""

    listening: bool = False  # whether commands are obeyed
    motion: Motion = Motion()  # the velocities
    commands: str = DEFAULT_STATE  # the set of commands in use, of the table
    bounded: BoundedMotion | None = None  # the motion under way, if it ends by itself
    remaining_steps: Steps = ()  # the steps after it
    pending: PendingCommand | None = None  # the command that waits for a yes
    last_moved: Steps = ()  # the steps of the last command that moved the robot

    @property
    def moving(self) -> bool:
        """Whether any velocity is not 0, or a remaining step may set one."""
        return self.motion.moving or bool(self.remaining_steps)


class Transition(NamedTuple):
    """The result of a command or of time: the new state, and events to send once.

    A command that was not obeyed may have a reason in `ignored`. What was said may be a yes: then
    the command that it `confirmed` is the one that is done.
    """

    state: State
    events: tuple[Event, ...] = ()
    obeyed: bool = True
    ignored: Ignored | None = None
    confirmed: GivenCommand | None = None


def at_rest(state: State) -> State:
    """Both velocities 0, no remaining steps; `listening` stays."""
    return replace(state, motion=halt(state.motion), bounded=None, remaining_steps=(), pending=None)


def obey(
    state: State,
    command: GivenCommand,
    table: CommandTable,
    safety: Safety,
    place: Place | None = None,
) -> Transition:
    """Apply one command; one that is not in the table changes nothing.

    `place` is where odometry has the robot. With `enabled` of `safety` False the bare rules hold.
    """
    name = command.name
    steps = table.steps(name, state.commands)
    if not state.listening and name not in table.starts:
        if safety.enabled and name in table.halts:  # S1, S2
            return Transition(at_rest(state))
        return Transition(state, obeyed=False, ignored="not_listening")
    if steps is None and state.commands != DEFAULT_STATE:
        return Transition(state, obeyed=False, ignored="not_now")
    try:
        steps = tuple(fill_slots(step, command.slots) for step in steps or ())
    except ConfigError as error:
        return _refuse(state, command, str(error))
    if steps and steps[0].again:
        if not state.last_moved:
            return _refuse(state, command, "nothing has moved yet")
        steps = _repeated(state.last_moved, steps)
    if steps and steps[0].confirm:
        return _ask(state, command, steps)
    return _carry_out(state, command, steps, safety, place)


def let_time_pass(state: State, t: float, safety: Safety, place: Place | None = None) -> Transition:
    """Let time pass until `t`, s: bounded motions end, next steps begin, questions expire."""
    if state.pending and t > state.pending.until:
        told = Notice(t, f'no answer: "{state.pending.command.name}" is not done')
        return Transition(replace(state, pending=None), (told,))
    if state.bounded is None:
        return Transition(state)
    bounded = update_bounded(state.bounded, state.motion, t, place)
    if not is_finished(bounded, state.motion):
        return Transition(replace(state, bounded=bounded))
    rested = replace(state, motion=halt(state.motion), bounded=None, remaining_steps=())
    return _take_steps(rested, state.remaining_steps, t, safety, place)


def _carry_out(
    state: State, command: GivenCommand, steps: Steps, safety: Safety, place: Place | None
) -> Transition:
    first = steps[0] if steps else None
    if first and first.answer is not None:
        return _answer(state, command, first, safety, place)
    state = replace(state, pending=None)
    if any(step.moves for step in steps):
        state = replace(state, last_moved=steps)
    if any(step.stop or step.starts_motion for step in steps):
        state = _without_bound(state)
    return _take_steps(state, steps, command.t, safety, place)


def _repeated(moved: Steps, again: Steps) -> Steps:
    """Return what moved last in place of the first of some steps; either may ask first."""
    first = replace(moved[0], confirm=again[0].confirm or moved[0].confirm)
    return (first, *moved[1:], *again[1:])


def _without_bound(state: State) -> State:
    if state.bounded is None:
        return state
    return replace(state, motion=halt(state.motion), bounded=None, remaining_steps=())


def _take_steps(
    state: State, steps: Steps, t: float, safety: Safety, place: Place | None
) -> Transition:
    """Take steps in order, up to the first bounded motion."""
    events: list[Event] = []
    for number, step in enumerate(steps):
        before = state
        motion = apply_safety(step, before.motion, apply_step(before.motion, step), safety)
        state = replace(state, motion=motion, **_changed_fields(step))
        if before.motion.moving and not motion.moving:
            state = at_rest(state)  # whatever ended the motion, no later step may start another one
        if step.listen is None or state.listening != before.listening:
            events += _step_events(step, t)
        if step.bounded:
            left = steps[number + 1 :]
            return Transition(
                replace(state, bounded=begin_bounded(step, t, place), remaining_steps=left),
                tuple(events),
            )
    return Transition(state, tuple(events))


def _changed_fields(step: Step) -> dict[str, object]:
    changed: dict[str, object] = {}
    if step.listen is not None:
        changed["listening"] = step.listen
    if step.listen is False:
        changed["commands"] = DEFAULT_STATE
    if step.state is not None:
        changed["commands"] = step.state
    return changed


def _step_events(step: Step, t: float) -> list[Event]:
    events: list[Event] = []
    if is_selection(step) and isinstance(step.publish, int):
        events.append(SelectedObject(t, step.publish))
    elif step.publish is not None and step.topic is not None:
        events.append(Publish(t, step.topic, step.publish))
    seconds = None if step.seconds is None else float(step.seconds)
    if step.run:
        events.append(StartProgram(t, step.run, seconds))
    if step.call:
        function, *arguments = step.call
        events.append(CallFunction(t, str(function), tuple(arguments), seconds))
    if step.play:
        events.append(Play(t, step.play))
    if step.say:
        events.append(Reply(t, step.say))
    return events


def _ask(state: State, command: GivenCommand, steps: Steps) -> Transition:
    """Ask first; it is obeyed after a yes alone, and another command cancels it."""
    question = steps[0].confirm
    said = question if isinstance(question, str) else f"{command.name}?"
    asked = PendingCommand(command, steps, command.t + ANSWER_TIMEOUT)
    told = (Reply(command.t, said),)
    return Transition(replace(state, pending=asked), told, obeyed=False, ignored="asked_first")


def _answer(
    state: State, command: GivenCommand, answer: Step, safety: Safety, place: Place | None
) -> Transition:
    asked = state.pending
    if asked is None or command.t > asked.until:
        return Transition(replace(state, pending=None), obeyed=False, ignored="nothing_asked")
    state = replace(state, pending=None)
    said = _step_events(answer, command.t)
    if not answer.answer:
        return Transition(state, tuple(said))
    now = dataclasses.replace(asked.command, t=command.t)
    done = _carry_out(state, now, asked.steps, safety, place)
    return done._replace(events=(*said, *done.events), confirmed=now)


def _refuse(state: State, command: GivenCommand, why: str) -> Transition:
    told = Notice(command.t, f'"{command.name}" cannot be done: {why}')
    return Transition(state, (told,), obeyed=False)
