"""What the robot obeys: the state machine of a run, one message at a step. Pure.

    message            state                                          events
    partial            halts, if the command would end the motion     itself
    utterance, unsure  its name wakes                                 itself; perhaps a question
    utterance          what was asked is forgotten; obeyed            itself, obeyed or why not;
                       unless late, rehearsed, asleep or refused      what the command does
    halt               at rest; what was begun before is late         a notice
    stop               at rest; what ended before is late             a notice
    health: lost       as by a stop; its sources are late until back  a notice
    renewal            at rest; all is late until it is over          a notice
    rehearsal          nothing but what stops is obeyed until it ends none
    beat               bounded motions go on or end (S6)              notices, the velocity
    notice, ended      the same                                       itself

`voz.control.state_machine` has what an obeyed command does, `voz.control.attention` names and
questions. Whatever changes the attention is followed by an `Attention`.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from typing import Any, TypeAlias

import msgspec
from msgspec.structs import asdict, replace

from voz.control.attention import (
    NOTHING,
    AttentionState,
    answer,
    forget_old_question,
    forget_question,
    is_asleep,
    put_question,
    question_about,
    stay_awake,
    wake,
)
from voz.control.messages import (
    Beat,
    ControllerMessage,
    Halt,
    Health,
    Rehearsal,
    Renewal,
    StopMotion,
)
from voz.control.motion import Place
from voz.control.safety import UNWATCHED_MOTION_LIMIT, motion_has_expired
from voz.control.state_machine import GivenCommand, State, Transition, at_rest, let_time_pass, obey
from voz.control.table import DEFAULT_STATE, HELP, TYPED_HELP, CommandTable, can_move
from voz.events import (
    START_SPEECH,
    Attention,
    Event,
    Ignored,
    Notice,
    Partial,
    Reply,
    Twist,
    Utterance,
)
from voz.settings import Ask, Safety
from voz.texts import ENGLISH, list_texts, text

MAX_HELP_SHOWN = 12
"""Sentences that a typed `help` shows."""

MAX_HELP_SPOKEN = 3
"""Sentences that the robot says to a spoken one: more nobody remembers."""


class Rules(msgspec.Struct, frozen=True):
    """By what a robot is controlled."""

    table: CommandTable  # what each command does
    safety: Safety = Safety()  # the safety rules' settings
    name: str = ""  # what the robot is called; spoken commands count after it. Empty if all count
    ask: Ask = "never"  # what is asked back
    # The sources of commands whose givers do not watch the robot: what these set in motion has an
    # end of its own, or ends after `UNWATCHED_MOTION_LIMIT`.
    unwatched_sources: frozenset[str] = frozenset()
    language: str = ENGLISH  # in which the robot asks and answers


class Loss(msgspec.Struct, frozen=True):
    """Something that is lost, by its sources."""

    sources: tuple[str, ...]  # of the commands that come from it
    commanded: bool = False  # whether the last command since was of somebody who is still there


class ControllerState(msgspec.Struct, frozen=True):
    """The state of a run between two messages; it begins with the robot at rest.

    Attributes:
        rules: by what the robot is controlled.
        robot: its motion, and whether it listens.
        attention: until when it is awake, and what it has asked.
        hears_names: whether what is heard may lack the robot's name.
        reported: the attention that receivers know of.
        last_command: when a command was last obeyed, s.
        stopped_at: when the robot was last stopped for a loss, s; older commands move nothing.
        stop_begun: when somebody last began to say a stop, or pressed a key, s.
        unwatched_until: when a motion ends that nobody watches, s.
        rehearsing: whether only commands that stop the robot are obeyed.
        renewing: whether the commands are being renewed; meanwhile nothing moves.
        losses: what is lost, by name.
    """

    rules: Rules
    robot: State = State()
    attention: AttentionState = AttentionState()
    hears_names: bool = False
    reported: Attention = Attention(0.0, awake=True)
    last_command: float = 0.0
    stopped_at: float = -math.inf  # not 0: the first utterance may have begun before the run
    stop_begun: float = -math.inf
    unwatched_until: float = math.inf
    rehearsing: bool = False
    renewing: bool = False
    losses: Mapping[str, Loss] = {}


Result: TypeAlias = tuple[ControllerState, tuple[Event, ...]]
"""The state after a message, and what receivers are to know of it."""


def step(
    state: ControllerState, message: ControllerMessage, now: float, place: Place | None = None
) -> Result:
    """Let a message take effect at a time of the run, s; what was heard does so at its own.

    `place` is where odometry has the robot then.
    """
    match message:
        case Partial():
            return _halt_early(state, message, place)
        case Utterance(accepted=False):
            return _take_unsure(state, message)
        case Utterance():
            return _take_command(state, message, place)
        case Halt(why, t):
            state = replace(halted(state), stop_begun=max(state.stop_begun, t))
            return state, (Notice(now, why, good=True, stops=True),)
        case StopMotion(why):
            return _stop(state, now, why)
        case Health():
            return _note_health(state, message, now)
        case Renewal():
            return _renew(state, message, now)
        case Rehearsal(on):
            return replace(state, rehearsing=on), ()
        case Beat():
            return _beat(state, now, place)
        case _:
            return state, (message,)


def halted(state: ControllerState) -> ControllerState:
    """The robot stands still from now on; what was asked is forgotten."""
    attention = forget_question(state.attention)
    return replace(state, robot=at_rest(state.robot), attention=attention)


def change_rules(state: ControllerState, **changes: Any) -> ControllerState:
    """Control by other rules from now on: `changes` are those of `Rules`."""
    return replace(state, rules=replace(state.rules, **changes))


def _halt_early(state: ControllerState, event: Partial, place: Place | None) -> Result:
    # A needless halt is better than a late one; the utterance follows.
    if state.robot.moving and not _preview(state, event, place).state.moving:
        state = halted(state)
    return state, (event,)


def _take_unsure(state: ControllerState, event: Utterance) -> Result:
    state = replace(state, hears_names=state.hears_names or event.named is not None)
    if event.named:  # surely, though the command is not
        state = replace(state, attention=wake(state.attention, event))
    state, changed = _report_attention(state, event.t)
    state, asked = _ask_back(state, event)
    return state, (replace(event, obeyed=False), *changed, *asked)


def _take_command(state: ControllerState, event: Utterance, place: Place | None) -> Result:
    state = replace(state, hears_names=state.hears_names or event.named is not None)
    why: Ignored | None = event.ignored
    if _is_late(state, event):
        why = "too_late"
    elif state.rehearsing and why != "too_late":
        why = "rehearsal"
    state, said, events = _attend(state, replace(event, ignored=why), place)
    if said.obeyed:
        losses = {
            name: replace(loss, commanded=said.source not in loss.sources)
            for name, loss in state.losses.items()
        }
        state = replace(state, losses=losses)
    state, changed = _report_attention(state, event.t)
    return state, (said, *events, *changed)


def _is_late(state: ControllerState, event: Utterance) -> bool:
    """Whether the robot was stopped after somebody began to say this, or its source is lost."""
    overtaken = event.end < state.stopped_at or event.start < state.stop_begun
    lost = any(event.source in loss.sources for loss in state.losses.values())
    return overtaken or lost or state.renewing


Obeyed: TypeAlias = tuple[ControllerState, Utterance, tuple[Event, ...]]
"""The state after an utterance, the utterance with what became of it, and what it does."""


def _attend(state: ControllerState, said: Utterance, place: Place | None) -> Obeyed:
    """Obey what was said to the robot: after its name, or in answer to it."""
    meant = answer(state.attention, said)
    attention = forget_question(state.attention)
    if said.named and not said.ignored:
        attention = wake(attention, said)
    state = replace(state, attention=attention)
    if said.spoken and _is_asleep(state, said.start):
        return _obey_asleep(state, said, place)
    if meant is NOTHING or (said.named and said.text == state.rules.name):
        return state, replace(said, obeyed=not said.ignored), ()
    return _obey(state, replace(said, **asdict(meant)) if meant else said, place)


def _obey_asleep(state: ControllerState, said: Utterance, place: Place | None) -> Obeyed:
    """Only what stops has an effect."""
    if said.name in state.rules.table.halts:
        state = halted(state)
    if said.name in state.rules.table.stops:
        return _obey(state, said, place)
    return state, replace(said, obeyed=False, ignored="asleep"), ()


def _obey(state: ControllerState, said: Utterance, place: Place | None) -> Obeyed:
    """Let a command take effect."""
    if _is_help(state, said):
        return _help(state, said)
    done = _preview(state, said, place)
    if meant := done.confirmed:
        said = replace(said, text=meant.text, command=meant.name, slots=meant.slots)
    if said.ignored and not _is_harmless(state, said, done):
        return state, replace(said, obeyed=False), ()
    if done.obeyed:
        said = replace(said, obeyed=True, ignored=None)
        state = _note_command(state, said, done)
    else:
        said = _not_obeyed(state, said, done.ignored)
    state = replace(state, robot=done.state)
    if asked := done.state.pending:
        state = replace(state, attention=stay_awake(state.attention, asked.until))
    return state, said, done.events


def _is_help(state: ControllerState, said: Utterance) -> bool:
    defined = any(HELP in own for own in state.rules.table.sets.values())
    return said.name == TYPED_HELP or (said.name == HELP and not defined)


def _help(state: ControllerState, said: Utterance) -> Obeyed:
    """Tell what may be said now: who says it hears a few commands, who types it reads many."""
    listening, table = state.robot.listening, state.rules.table
    if said.ignored:
        return state, replace(said, obeyed=False), ()
    if said.spoken and not listening:
        return state, _not_obeyed(state, said, "not_listening"), ()
    usable = table.usable(listening, state.robot.commands)
    if said.spoken:  # without what stops: it is listened for while the robot speaks
        texts = [one for name, one in usable.items() if name not in table.halts]
        event: Event = Reply(said.t, _spoken_help(texts[:MAX_HELP_SPOKEN], state.rules.language))
    else:
        texts = [*state.reported.answers, *usable.values()]
        more = len(texts) - MAX_HELP_SHOWN
        told = ", ".join(texts[:MAX_HELP_SHOWN])
        told = f"you can say: {told} and {more} more" if more > 0 else f"you can say: {told}"
        event = Notice(said.t, told, good=True)
    return state, replace(said, obeyed=True), (event,)


def _spoken_help(texts: Sequence[str], language: str) -> str:
    *others, last = texts or [text("nothing", language)]
    listed = [", ".join(others), last] if others else [last]
    commands = list_texts("{one} or {other}", listed, language)
    return text("you can say {commands}", language, commands=commands)


def _not_obeyed(state: ControllerState, said: Utterance, why: Ignored | None) -> Utterance:
    said = replace(said, obeyed=False, ignored=why)
    if why == "not_listening" and state.rules.table.wake != START_SPEECH:
        said = replace(said, say_first=state.rules.table.wake)
    return said


def _preview(state: ControllerState, event: Utterance | Partial, place: Place | None) -> Transition:
    slots = event.slots if isinstance(event, Utterance) else {}
    command = GivenCommand(event.name, slots, event.t, event.text)
    return obey(state.robot, command, state.rules.table, state.rules.safety, _known(place))


def _known(place: Place | None) -> Place | None:
    return place if place is not None and all(map(math.isfinite, place)) else None


def _is_harmless(state: ControllerState, said: Utterance, done: Transition) -> bool:
    """Whether a command may be obeyed though it is to be ignored.

    While the robot speaks and in a rehearsal, only what stops it may. What comes too late may
    still end the motion, and begin or end the listening.
    """
    table = state.rules.table
    if said.ignored != "too_late":
        return said.name in table.stops
    switches = said.name in table.halts | table.starts
    silent = all(isinstance(event, Reply) for event in done.events)
    return silent and not done.state.moving and (switches or state.robot.moving)


def _note_command(state: ControllerState, said: Utterance, done: Transition) -> ControllerState:
    """Note when a command was obeyed, and limit what somebody moves who does not watch it."""
    rules, stop_begun, until = state.rules, state.stop_begun, state.unwatched_until
    if said.name in rules.table.halts:
        stop_begun = max(stop_begun, said.start)
    if done.state.motion != state.robot.motion or can_move(rules.table, said.name):
        unwatched = said.source in rules.unwatched_sources
        until = said.t + UNWATCHED_MOTION_LIMIT if unwatched else math.inf
    return replace(state, last_command=said.t, stop_begun=stop_begun, unwatched_until=until)


def _ask_back(state: ControllerState, event: Utterance) -> Result:
    """Ask about an utterance that is not sure enough, once."""
    listens = state.robot.listening and not (state.rehearsing or state.renewing)
    busy = state.robot.pending or state.attention.question
    if not event.spoken or not listens or busy or _is_asleep(state, event.start):
        return state, ()
    rules = state.rules
    question = question_about(event, rules.ask, rules.table, rules.language)
    if question is None:
        return state, ()
    state = replace(state, attention=put_question(state.attention, question))
    state, changed = _report_attention(state, event.t)
    return state, (Reply(event.t, question.text), *changed)


def _is_asleep(state: ControllerState, t: float) -> bool:
    needs_name = bool(state.rules.name) or state.hears_names
    return needs_name and is_asleep(state.attention, t)


def _report_attention(state: ControllerState, now: float) -> Result:
    """Report what receivers do not know yet of the robot's attention."""
    if asked := state.attention.question:
        answers = tuple(asked.answers)
    elif state.robot.pending:
        answers = state.rules.table.answers(state.robot.commands)
    else:
        answers = ()
    attention = Attention(now, not _is_asleep(state, now), answers)
    if replace(attention, t=state.reported.t) == state.reported:
        return state, ()
    return replace(state, reported=attention), (attention,)


def _stop(state: ControllerState, now: float, why: str, good: bool = False) -> Result:
    """End the motion until a new command; good news stops nothing: the robot has stood still."""
    return replace(halted(state), stopped_at=now), (Notice(now, why, good, stops=not good),)


def _note_health(state: ControllerState, health: Health, now: float) -> Result:
    """S5: stop when something is lost, and when it is back.

    While it is lost, what moves the robot is stopped again, unless that is a new command that came
    from elsewhere.
    """
    known = state.losses.get(health.name)
    if bool(health.problem) != bool(known):
        losses = {name: loss for name, loss in state.losses.items() if name != health.name}
        if health.problem:
            losses[health.name] = Loss(health.sources)
        state = replace(state, losses=losses)
    elif not known or known.commanded or not state.robot.moving:
        return state, ()
    if health.problem:
        return _stop(state, now, f"{health.problem}: the robot stops")
    # Commands of the meantime are out of date.
    return _stop(state, now, f"{health.back}; the robot waits for a command", good=True)


def _renew(state: ControllerState, renewal: Renewal, now: float) -> Result:
    """Stop while the commands are being renewed, and take what they do from now on."""
    moved = state.robot.moving
    stop_begun = max(state.stop_begun, now)
    state = replace(halted(state), stop_begun=stop_begun, renewing=renewal.under_way)
    if renewal.table:
        robot = replace(state.robot, commands=DEFAULT_STATE, last_moved=())
        state = replace(change_rules(state, table=renewal.table), robot=robot)
    if not renewal.under_way:
        return state, (Notice(now, renewal.why, good=renewal.table is not None),)
    if not moved:
        return state, ()
    return state, (Notice(now, f"{renewal.why}: the robot stops", good=True, stops=True),)


def _beat(state: ControllerState, now: float, place: Place | None) -> Result:
    """Let time pass, and send the velocities."""
    done = let_time_pass(state.robot, now, state.rules.safety, _known(place))
    state = replace(state, robot=done.state)
    expired: tuple[Event, ...] = ()
    if why := _limit_reached(state, now):
        state = halted(state)
        expired = (Notice(now, f"{why}: the robot stops", stops=True),)
    state = replace(state, attention=forget_old_question(state.attention, now))
    state, changed = _report_attention(state, now)
    twist = Twist(now, *state.robot.motion.velocities())
    return state, (*done.events, *expired, *changed, twist)


def _limit_reached(state: ControllerState, now: float) -> str:
    """Say why a motion without an end of its own has lasted too long; empty if it has not."""
    robot, safety = state.robot, state.rules.safety
    if motion_has_expired(robot.moving, now - state.last_command, safety):
        return f"no command for {safety.motion_time_limit:g} s"
    if robot.motion.moving and robot.bounded is None and now >= state.unwatched_until:
        return f"moved for {UNWATCHED_MOTION_LIMIT:g} s with nobody there"
    return ""
