"""Obeys what was heard: turns utterances into events for all receivers."""

from __future__ import annotations

import math
import os
from collections.abc import Callable, Sequence

from msgspec.structs import asdict, replace

from voz.config import default_commands
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
from voz.control.bounded_motion import Place
from voz.control.safety import UNWATCHED_MOTION_LIMIT, motion_has_expired
from voz.control.state_machine import GivenCommand, State, Transition, at_rest, let_time_pass, obey
from voz.control.table import DEFAULT_STATE, CommandTable, can_move
from voz.errors import ConfigError, RobotError
from voz.events import (
    Attention,
    Event,
    Ignored,
    Notice,
    Partial,
    Receiver,
    Reply,
    Twist,
    Utterance,
)
from voz.inbox import Renewal
from voz.printable import shown_value
from voz.process.forks import ends_forks
from voz.records import check_type, is_finite
from voz.settings import Ask, Safety

LATEST = 1e12
"""Of a run, s; events hold no later time."""


class Controller:
    """Obeys commands and sends velocities; time comes in with each call.

    Attributes:
        receivers: called with every event, in order; none of them may wait for anything.
        odometry: returns where the robot is at a time of the run, s, without waiting.
        stopped_at: when the robot was last stopped for a loss, s; older commands move nothing.
        table: what each command does.
        rehearsing: whether only commands that stop the robot are obeyed.
        unwatched_sources: the sources of commands whose givers do not watch the robot: what these
            set in motion has an end of its own, or ends after `UNWATCHED_MOTION_LIMIT`.
        name: what the robot is called; spoken commands count after it. Empty if all count.
        ask: what is asked back.
    """

    def __init__(
        self,
        receivers: Sequence[Receiver],
        safety: Safety,
        listening: bool = False,
        table: CommandTable | None = None,
        odometry: Callable[[float], Place | None] = lambda _: None,
    ) -> None:
        """Start with the robot at rest.

        Args:
            receivers: called with every event, in order; none of them may wait for anything.
            safety: the safety rules' settings.
            listening: whether commands are obeyed before a `start speech`.
            table: what each command does; None is what they do in the list that comes with voz.
            odometry: returns where the robot is at a time of the run, s, without waiting.

        Raises:
            ConfigError: an argument is something else.
        """
        check_type(Safety, safety, "safety")
        check_type(bool, listening, "listening")
        check_type((CommandTable, type(None)), table, "table")
        self.receivers = [*receivers]
        self._safety = safety
        self.table = table or default_commands()
        self.odometry = odometry
        self._process = os.getpid()
        self._state = State(listening=listening)
        self._last_command = 0.0
        # Not 0: the first utterance may have begun before the run.
        self.stopped_at = -math.inf
        self._stop_begun = -math.inf  # when somebody last began to say so, or pressed a key, s
        self.rehearsing = False
        self._late_sources: set[str] = set()
        self._renewing = False  # the commands; meanwhile nothing moves
        self.unwatched_sources: set[str] = set()
        self._unwatched_until = math.inf  # when a motion ends that nobody watches, s
        self.name = ""
        self._hears_names = False  # what is heard may lack the robot's name
        self.ask: Ask = "never"
        self._attention = AttentionState()
        self._told = Attention(0.0, awake=True)  # what receivers know

    @property
    def velocities(self) -> tuple[float, float]:
        """The velocities that are sent now, m/s and rad/s."""
        return self._state.motion.velocities()

    @property
    def moving(self) -> bool:
        """Whether the robot is asked to move."""
        return self._state.moving

    @property
    def is_forked(self) -> bool:
        """Whether this process was forked from that of the controller, which drives on there."""
        return os.getpid() != self._process

    @property
    def listening(self) -> bool:
        """Whether commands are obeyed."""
        return self._state.listening

    @property
    def awake(self) -> bool:
        """Whether spoken commands count, besides those that stop."""
        return self._told.awake

    def hear(self, event: Utterance | Partial, late: bool = False) -> None:
        """Obey an utterance if it is accepted; halt at what may be a command that stops.

        Args:
            event: what was heard.
            late: whether it is out of date; then it can move nothing.
        """
        if isinstance(event, Partial):
            # A needless halt is better than a late one; the utterance follows.
            if self.moving and not self._preview(event).state.moving:
                self.halt()
            self.emit(event)
            return
        self._hears_names |= event.named is not None
        if not event.accepted:
            if event.named:  # surely, though the command is not
                self._attention = wake(self._attention, event)
            told = [replace(event, obeyed=False), *self._changed_attention(event.t)]
            self.emit(*told, *self._ask_back(event))
        else:
            late = late or self._is_overtaken(event) or event.source in self._late_sources
            late = late or self._renewing
            why: Ignored | None = "too_late" if late else "rehearsal" if self.rehearsing else None
            events = self._attend(replace(event, ignored=why) if why else event)
            self.emit(*events, *self._changed_attention(event.t))

    def mark_late(self, source: str, behind: bool) -> None:
        """Note whether a source is behind; late commands move nothing."""
        (self._late_sources.add if behind else self._late_sources.discard)(source)

    def halt(self) -> None:
        """Ask the robot to stand still from now on; what was asked is forgotten."""
        self._state = at_rest(self._state)
        self._attention = forget_question(self._attention)

    def stop(self, now: float, why: str, good: bool = False) -> None:
        """End the motion until a new command, and say why.

        Args:
            now: the time of the run, s.
            why: for people.
            good: whether that is good news.

        Raises:
            ConfigError: the time is no number; the motion is ended all the same.
        """
        self.halt()
        check_time(now)
        self.stopped_at = now
        # Good news stops nothing: the robot has stood still since the loss.
        self.emit(Notice(now, why, good, stops=not good))

    def stop_by_hand(self, now: float, why: str, pressed: float = 0.0) -> None:
        """Ask the robot to stand still, because somebody wants it.

        Args:
            now: the time of the run, s.
            why: for people.
            pressed: when the key was, s; a command that began before moves nothing.

        Raises:
            ConfigError: a time is no number; the motion is ended all the same.
        """
        self.halt()
        check_time(now)
        check_time(pressed)
        self._stop_begun = max(self._stop_begun, pressed)
        self.emit(Notice(now, why, good=True, stops=True))

    def renew(self, now: float, renewal: Renewal) -> None:
        """Stop while the commands are being renewed, and take what they do from now on.

        Args:
            now: the time of the run, s.
            renewal: that it has begun, or is over; what was said before then moves nothing.
        """
        moved = self.moving
        self.halt()
        self._stop_begun = max(self._stop_begun, now)
        self._renewing = renewal.under_way
        if renewal.table:
            self.table = renewal.table
            self._state = replace(self._state, commands=DEFAULT_STATE, last_moved=())
        if not renewal.under_way:
            self.emit(Notice(now, renewal.why, good=renewal.table is not None))
        elif moved:
            self.emit(Notice(now, f"{renewal.why}: the robot stops", good=True, stops=True))

    def send(self, now: float) -> None:
        """Let time pass, and send the velocities once.

        Args:
            now: the time of the run, s.

        Raises:
            ConfigError: the time is no number.
        """
        check_time(now)
        events = self._apply(let_time_pass(self._state, now, self._safety, self._place(now)))
        if motion_has_expired(self.moving, now - self._last_command, self._safety):
            self.halt()
            limit = self._safety.motion_time_limit
            events.append(Notice(now, f"no command for {limit:g} s: the robot stops", stops=True))
        if (
            self._state.motion.moving
            and self._state.bounded is None
            and now >= self._unwatched_until
        ):
            self.halt()
            told = f"moved for {UNWATCHED_MOTION_LIMIT:g} s with nobody there: the robot stops"
            events.append(Notice(now, told, stops=True))
        self._attention = forget_old_question(self._attention, now)
        events += self._changed_attention(now)
        self.emit(*events, Twist(now, *self.velocities))

    def zero(self, now: float) -> None:
        """Send zero velocity once."""
        self.emit(Twist(now, 0.0, 0.0))

    def emit(self, *events: Event) -> None:
        """Hand events to all receivers, whatever one raises; raises the first error afterward.

        Raises:
            RobotError: this process was forked from the one that drives.
        """
        if self.is_forked:
            raise RobotError(
                "a forked process does not drive by the controller of the one that it comes from",
                "make a voz.Controller of its own there",
            )
        errors: list[BaseException] = []
        for event in events:
            for receive in self.receivers:
                try:
                    with ends_forks():
                        receive(event)
                except BaseException as error:  # zero has to reach those behind it
                    errors.append(error)
        if errors:
            raise errors[0]

    def _is_overtaken(self, event: Utterance) -> bool:
        """Whether the robot was stopped after somebody began to say this."""
        return event.end < self.stopped_at or event.start < self._stop_begun

    def _place(self, now: float) -> Place | None:
        place = self.odometry(now)
        return place if place is not None and all(map(math.isfinite, place)) else None

    def _preview(self, event: Utterance | Partial) -> Transition:
        slots = event.slots if isinstance(event, Utterance) else {}
        command = GivenCommand(event.name, slots, event.t, event.text)
        return obey(self._state, command, self.table, self._safety, self._place(event.t))

    def _attend(self, utterance: Utterance) -> list[Event]:
        """Obey what was said to the robot: after its name, or in answer to it."""
        attention, self._attention = self._attention, forget_question(self._attention)
        if utterance.named and not utterance.ignored:
            self._attention = wake(self._attention, utterance)
        meant = answer(attention, utterance)
        is_name = utterance.named and utterance.text == self.name
        if utterance.spoken and self._is_asleep(utterance.start):
            return self._obey_asleep(utterance)
        if is_name or meant is NOTHING:
            return [replace(utterance, obeyed=not utterance.ignored)]
        return self._obey(replace(utterance, **asdict(meant)) if meant else utterance)

    def _obey_asleep(self, utterance: Utterance) -> list[Event]:
        """Only what stops has an effect."""
        if utterance.name in self.table.halts:
            self.halt()
        if utterance.name in self.table.stops:
            return self._obey(utterance)
        return [replace(utterance, obeyed=False, ignored="asleep")]

    def _ask_back(self, event: Utterance) -> list[Event]:
        """Ask about an utterance that is not sure enough, once."""
        listens = self.listening and not (self.rehearsing or self._renewing)
        busy = self._state.pending or self._attention.question
        if not event.spoken or not listens or busy or self._is_asleep(event.start):
            return []
        question = question_about(event, self.ask, self.table)
        if question is None:
            return []
        self._attention = put_question(self._attention, question)
        return [Reply(event.t, question.text), *self._changed_attention(event.t)]

    def _is_asleep(self, t: float) -> bool:
        return (bool(self.name) or self._hears_names) and is_asleep(self._attention, t)

    def _changed_attention(self, now: float) -> list[Event]:
        """Return what receivers do not know yet of the robot's attention."""
        awake, answers = not self._is_asleep(now), self._answers()
        if (awake, answers) == (self._told.awake, self._told.answers):
            return []
        self._told = Attention(now, awake, answers)
        return [self._told]

    def _answers(self) -> tuple[str, ...]:
        """What may be said to the question that is open."""
        if asked := self._attention.question:
            return tuple(asked.answers)
        return self.table.answers(self._state.commands) if self._state.pending else ()

    def _obey(self, utterance: Utterance) -> list[Event]:
        """Let a command take effect; returns what receivers are to know of it."""
        transition = self._preview(utterance)
        if done := transition.confirmed:
            command, slots = done.name, done.slots
            utterance = replace(utterance, text=done.text, command=command, slots=slots)
        if utterance.ignored and not self._is_harmless(utterance, transition):
            return [replace(utterance, obeyed=False)]
        if transition.obeyed:
            utterance = replace(utterance, obeyed=True, ignored=None)
            self._last_command = utterance.t
            self._note_who_watches(utterance, transition)
            if utterance.name in self.table.halts:
                self._stop_begun = max(self._stop_begun, utterance.start)
        else:
            utterance = replace(utterance, obeyed=False, ignored=transition.ignored)
        events = self._apply(transition)
        if asked := self._state.pending:
            self._attention = stay_awake(self._attention, asked.until)
        return [utterance, *events]

    def _note_who_watches(self, utterance: Utterance, transition: Transition) -> None:
        """Limit a motion that is begun or changed by somebody who does not watch the robot."""
        changed = transition.state.motion != self._state.motion
        if changed or can_move(self.table, utterance.name):
            unwatched = utterance.source in self.unwatched_sources
            self._unwatched_until = utterance.t + UNWATCHED_MOTION_LIMIT if unwatched else math.inf

    def _apply(self, transition: Transition) -> list[Event]:
        self._state = transition.state
        return [*transition.events]

    def _is_harmless(self, utterance: Utterance, transition: Transition) -> bool:
        """Whether a command may be obeyed though it is to be ignored.

        While the robot speaks and in a rehearsal, only what stops it may. What comes too late may
        still end the motion, and begin or end the listening.
        """
        if utterance.ignored != "too_late":
            return utterance.name in self.table.stops
        switches = utterance.name in self.table.halts | self.table.starts
        silent = all(isinstance(event, Reply) for event in transition.events)
        return silent and not transition.state.moving and (switches or self.moving)


def is_time(now: float) -> bool:
    """Whether this can be a time of a run, s."""
    return is_finite(now) and abs(now) <= LATEST


def check_time(now: float) -> None:
    """Raise ConfigError for what is no time of a run, s."""
    if not is_time(now):
        raise ConfigError(f"the time of the run is {shown_value(now)}; give seconds")
