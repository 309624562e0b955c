"""One run of a robot: a clock, sources, receivers and watches, put together around a controller.

    microphone, keyboard, ROS ──▶ Inbox ──▶ ┐
    recordings, text, a bag  ──▶ (a Clock) ─┴▶ beat ──▶ Controller ──▶ receivers, each with a queue

Sources have threads of their own and put messages into an inbox, or are the clock themselves.
"""

from __future__ import annotations

from collections.abc import Callable, Collection, Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from functools import partial
from typing import TYPE_CHECKING, Any, Protocol, TypeAlias

from msgspec.structs import replace

from voz.config import Config
from voz.control.bounded_motion import Place
from voz.control.controller import ControllerState, Rules, change_rules
from voz.control.messages import End, Health
from voz.control.safety import zero_at_the_end
from voz.control.state_machine import State
from voz.control.table import CommandTable
from voz.events import (
    Attention,
    Ended,
    Event,
    Notice,
    Partial,
    Play,
    Receiver,
    Reply,
    Utterance,
)
from voz.inbox import Inbox
from voz.process.signals import defer_signals
from voz.run.beat import Check, beat
from voz.run.clocks import Clock
from voz.run.dispatcher import Dispatcher
from voz.run.programs import Programs
from voz.run.watch import Flood
from voz.settings import Speech
from voz.speech.reply_speaker import ReplySpeaker

if TYPE_CHECKING:
    from voz.robot.simulation.room_view import RoomView

Odometry: TypeAlias = Callable[[float], Place | None]
"""Returns where the robot is at a time of the run, s, without waiting; None if unknown."""


Trouble: TypeAlias = Callable[[], str | None]
"""Returns why something is lost now, without waiting; None if it is not."""


class SpeechInput(Protocol):
    """Where spoken commands come from: a microphone, a page, another recognizer.

    Attributes:
        source: of its utterances.
    """

    source: str

    def trouble(self, moving: bool) -> str | None:
        """Return why nothing is heard now, without waiting; None if all is well."""


@dataclass(frozen=True)
class OpenRobots:
    """The robots of a run, open, and what else gets its events.

    Attributes:
        receivers: called with every event, in order.
        troubles: return why a robot is lost, by its name; none without a real clock.
        odometry: returns where the robot is.
        show: prints a line where the robots print, on any thread.
        view: the simulated room, for a terminal.
    """

    receivers: list[Receiver]
    troubles: Mapping[str, Trouble]
    odometry: Odometry = lambda _: None
    show: Callable[[str], None] = lambda _: None
    view: RoomView | None = None


class Session:
    """One run: add receivers and watches, then `run` or `run_in_real_time`.

    Attributes:
        clock: the time, and what arrives.
        controller: obeys.
        receivers: called with every event, in order; none of them may wait for anything.
        checks: called in each beat with its time, s.
    """

    def __init__(self, clock: Clock, controller: Dispatcher) -> None:
        """Begin with the robot at rest."""
        self.clock = clock
        self.controller = controller
        self.receivers = controller.receivers
        self.checks: list[Check] = []
        self._at_once = False

    @property
    def table(self) -> CommandTable:
        """What each command does."""
        return self.controller.state.rules.table

    def change_rules(self, **changes: Any) -> None:
        """Control by other rules from now on; those of `Rules` are given."""
        self.controller.state = change_rules(self.controller.state, **changes)

    def add_robots(self, robots: OpenRobots) -> None:
        """Hand events to robots, take their odometry, and stop if one is lost (S5)."""
        self.receivers += robots.receivers
        self.controller.odometry = robots.odometry
        self.watch(robots.troubles)

    def watch(self, troubles: Mapping[str, Trouble], *sources: str) -> None:
        """Stop when one of these returns why it is lost (S5).

        Args:
            troubles: by names for messages.
            sources: of the commands that come from them; while one is lost they move nothing.
        """
        self.checks += [
            partial(self._check, name, trouble, f"{name} is there", sources)
            for name, trouble in troubles.items()
        ]

    def watch_input(self, speech_input: SpeechInput) -> None:
        """Stop when nothing is heard (S5), and send each changed velocity at once."""

        def check(now: float) -> None:
            lost = partial(speech_input.trouble, self.controller.moving)
            self._check("hearing", lost, "listening again", (speech_input.source,), now)

        self.checks.insert(0, check)
        self._at_once = True

    def _check(
        self, name: str, trouble: Trouble, back: str, sources: tuple[str, ...], now: float
    ) -> None:
        self.controller.take(Health(name, trouble(), back, sources), now)

    def run(self, finish: Callable[[], None] = lambda: None) -> None:
        """Drive until the clock has no more; zero velocity is sent last (S7).

        Before that zero, `finish` is called; it may send events.
        """
        with zero_at_the_end(self._send_zero):
            self._drive()
            finish()

    def run_in_real_time(self, inbox: Inbox) -> None:
        """Drive until a message or a signal ends it; zero velocity is sent last (S7).

        The clock takes messages from the inbox. Raises SystemExit if a signal came before.
        """
        self.checks.append(Flood(self.controller, inbox).check)
        with (
            zero_at_the_end(self._send_zero),
            defer_signals(lambda: inbox.put(End())),
        ):
            self._drive()

    def _drive(self) -> None:
        raise_if_any(beat(self.controller, self.clock, self.checks, self._at_once))

    def _send_zero(self) -> None:
        self.controller.zero(self.clock.now())


def new_session(settings: Config, clock: Clock, listening: bool = False) -> Session:
    """Begin with the robot at rest; `listening` obeys commands before a `start speech`."""
    recognition = settings.recognition
    rules = Rules(settings.table, settings.safety, recognition.name, recognition.ask)
    return Session(clock, Dispatcher(ControllerState(rules, State(listening=listening))))


class Answerable(Protocol):
    """A recognizer, or what has one."""

    def expect(self, answers: tuple[str, ...]) -> None:
        """Understand these answers too from now on; none: only commands."""


def answer_receiver(recognizer: Answerable) -> Receiver:
    """Return a receiver that lets a recognizer understand answers to what the robot asks."""

    def receive(event: Event) -> None:
        if isinstance(event, Attention):
            recognizer.expect(event.answers)

    return receive


@contextmanager
def open_speaker(
    settings: Speech, replies: Sequence[str], warn: Callable[[str], None]
) -> Iterator[ReplySpeaker | None]:
    """Open a speaker of the replies for a `with` block; None if the robot is silent.

    Args:
        settings: whose voice, and whether at all.
        replies: rendered beforehand.
        warn: takes problems, on any thread.
    """
    if not settings.enabled:
        yield None
        return
    with ReplySpeaker(settings.voice, replies, warn) as speaker:
        speaker.mixer.barge_in = settings.barge_in
        yield speaker


def speech_receivers(speaker: ReplySpeaker | None) -> list[Receiver]:
    """Return a receiver that lets a speaker say replies and play sounds; none without a speaker."""

    def receive(event: Event) -> None:
        if speaker and isinstance(event, Reply):
            speaker.say(event.text)
        elif speaker and isinstance(event, Play):
            speaker.play(event.sound)

    return [receive] if speaker else []


def interruption_receivers(speaker: ReplySpeaker | None, halts: Collection[str]) -> list[Receiver]:
    """Return a receiver that lets a speaker fall silent; to be called before that of its replies.

    It does at what may be a command in `halts`, and with `barge_in` at any that is obeyed.
    """

    def receive(event: Event) -> None:
        if speaker is None or not isinstance(event, Partial | Utterance):
            return
        if isinstance(event, Utterance) and not event.obeyed:
            return
        if event.name in halts or (isinstance(event, Utterance) and speaker.mixer.barge_in):
            speaker.interrupt()

    return [receive] if speaker else []


@contextmanager
def open_programs(
    table: CommandTable, inbox: Inbox, clock: Clock, show: Callable[[str], None]
) -> Iterator[Programs]:
    """Open what starts programs and functions, for a `with` block; their ends go to the inbox.

    Each line that a program prints goes to `show`. Raises ConfigError if one does not exist.
    """

    def put(ended: Ended) -> None:
        inbox.put(replace(ended, t=clock.now()))

    with Programs(table, put, show) as programs:
        yield programs


class Warn(Protocol):
    """Takes a line for people, and whether it is good news, on any thread."""

    def __call__(self, text: str, good: bool = False) -> None:
        """Take a line."""


def warner(inbox: Inbox, clock: Clock) -> Warn:
    """Return a function that puts a line into the inbox as a Notice, on any thread."""
    return lambda text, good=False: inbox.put(Notice(clock.now(), text, good))


def raise_if_any(error: BaseException | None) -> None:
    """Raise the error that ended the beat, if there is one."""
    if error:
        raise error
