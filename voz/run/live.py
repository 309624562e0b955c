"""A run by a microphone and the keyboard: which sources and receivers it has."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import AbstractContextManager, ExitStack, contextmanager, nullcontext
from functools import partial
from typing import NamedTuple, Protocol, TypeAlias

from rich.console import RenderableType

from voz.config import Config
from voz.control.bound import Place
from voz.events import Event, Receiver
from voz.hearing.half_duplex import PlayedSound
from voz.hearing.microphone_thread import Hearing, SoundFrom, SoundRecorder, sound_card
from voz.inbox import Halt, Inbox
from voz.recognition.recognizer import Recognizer
from voz.run.assembly import Ears, replies_to, run_control_loop, speaking, starting, warner
from voz.run.clocks import Clock, WallClock
from voz.run.controller import Controller
from voz.run.renewal import renewing
from voz.run.text_commands import TextCommands
from voz.terminal.display import Display
from voz.terminal.drawn import DrawnTerminal
from voz.terminal.keyboard import Line, keys, somebody_types

PAGE = "the operator's page"

Typist: TypeAlias = Callable[[str, str], None]
"""Obeys a sentence; the second is its source."""

Other: TypeAlias = Callable[[Typist, Callable[[str], None]], AbstractContextManager[None]]
"""Another recognizer, given what obeys it, and what to tell why it is heard no more."""


class Page(Protocol):
    """A page that shows the run and drives in it, too."""

    @property
    def sound(self) -> SoundFrom | None:
        """Its browser as a microphone; None if the robot's own is listened to."""

    def beside(self, own: PlayedSound | None) -> PlayedSound:
        """What a microphone may hear that nobody says: what the robot says, what browsers play."""

    def receive(self, event: Event) -> None:
        """Take an event; it never waits."""

    def trouble(self, moving: bool) -> str | None:
        """Tell why nobody drives by it any more, if that matters."""

    def serving(self, parts: Shown) -> AbstractContextManager[Ears]:
        """Serve it for a `with` block; gives what listens."""


class Shown(NamedTuple):
    """What a page shows of a run.

    Attributes:
        controller: what obeys.
        hearing: what listens.
        mixer: what the robot speaks by, if it does.
        recognizer: what understands.
        settings: of the run.
        recorder: keeps what is heard, if anything does.
    """

    controller: Controller
    hearing: Hearing
    mixer: PlayedSound | None
    recognizer: Recognizer
    settings: Config
    recorder: SoundRecorder | None


class Seat(NamedTuple):
    """What the operator wants.

    Attributes:
        device: the microphone's number or a part of its name; None is the default one.
        listening: whether commands are obeyed before a `start speech`.
        terminal: draws the display, if there is somebody to see it.
        tell: where there is no display, takes the line that it listens.
        show: takes each line that a program of a command prints, on any thread.
        record: opens what keeps what is heard; given what to tell if it cannot.
        extra: what the terminal shows besides.
        also: another recognizer, whose sentences are obeyed.
        odometry: tells where the robot is at a time of the run, s, without waiting.
        page: makes a page that shows the run, from where its commands go and the time.
    """

    device: str | None = None
    listening: bool = False
    terminal: DrawnTerminal | None = None
    tell: Callable[[str], None] = lambda _: None
    show: Callable[[str], None] = lambda _: None
    record: Callable[[Callable[[str], None]], AbstractContextManager[SoundRecorder]] | None = None
    extra: RenderableType | None = None
    also: Other | None = None
    odometry: Callable[[float], Place | None] = lambda _: None
    page: Callable[[Inbox, Clock], Page] | None = None


def run_live(
    receivers: Sequence[Receiver],
    robots: Mapping[str, Callable[[], str | None]],
    settings: Config,
    recognizer: Recognizer,
    inbox: Inbox,
    seat: Seat,
) -> None:
    """Drive a robot by a microphone and the keyboard until a signal ends the program.

    Args:
        receivers: called with every event, in order.
        robots: tells of each robot, by its name, why it is lost (S5).
        settings: the safety rules and the voice.
        recognizer: what understands; what it knows may be typed, too.
        inbox: what is heard goes through it; others may warn of something by it.
        seat: what the operator wants.

    Raises:
        AudioError: there is no such microphone.
    """
    table = settings.table
    clock = WallClock(inbox)
    warn = warner(inbox, clock)
    texts = TextCommands(lambda: recognizer.commands, inbox, clock.now)
    with ExitStack() as parts:
        page = seat.page(inbox, clock) if seat.page else None
        recorder = parts.enter_context(seat.record(warn) if seat.record else nullcontext())
        speaker = parts.enter_context(speaking(settings.speech, table.replies, warn))
        mixer = speaker.mixer if speaker else None
        own = mixer if settings.speech.half_duplex else None
        hearing = Hearing(
            recognizer,
            (page.sound if page else None) or sound_card(seat.device),
            inbox,
            clock.now,
            page.beside(own) if page else own,
            settings.recognition.never_missed,
            recorder,
        )
        parts.enter_context(hearing)
        parts.enter_context(renewing(recognizer, table, warn))
        stop = partial(_stop, inbox, clock)
        line = parts.enter_context(keys(stop, texts.take, texts.continues, warn))
        if seat.also:
            parts.enter_context(seat.also(texts.take, partial(_unheard, inbox, clock)))
        start = parts.enter_context(starting(table, inbox, clock, seat.show))
        told = [*receivers, *replies_to(speaker), start, *([page.receive] if page else [])]
        controller = Controller(told, settings.safety, seat.listening, table, seat.odometry)
        display = _display(seat, controller, hearing, line, recorder)
        parts.enter_context(_showing(display, told, seat, hearing.device))
        ears: Ears = hearing
        if page:
            shown = Shown(controller, hearing, mixer, recognizer, settings, recorder)
            ears = parts.enter_context(page.serving(shown))
            robots = {**robots, PAGE: partial(_trouble, page, controller)}
        run_control_loop(controller, inbox, clock, robots, ears)


def _stop(inbox: Inbox, clock: Clock) -> None:
    inbox.put(Halt(t=clock.now()))


def _unheard(inbox: Inbox, clock: Clock, why: str) -> None:
    _stop(inbox, clock)
    warner(inbox, clock)(f"{why}: the robot stops")


def _display(
    seat: Seat, controller: Controller, hearing: Hearing, line: Line, recorder: SoundRecorder | None
) -> Display:
    return Display(
        hearing,
        lambda: controller.listening,
        lambda: line.text,
        lambda: recorder.note if recorder else "",
        seat.extra,
    )


@contextmanager
def _showing(display: Display, told: list[Receiver], seat: Seat, microphone: str) -> Iterator[None]:
    """Draw the run on the terminal for a `with` block; where there is none, say that it begins."""
    if seat.terminal is None:
        seat.tell(_ready(microphone, seat))
        yield
        return
    told.append(display.receive)
    with seat.terminal.drawn(display.__rich__):
        yield


def _trouble(page: Page, controller: Controller) -> str | None:
    return page.trouble(controller.moving)


def _ready(microphone: str, seat: Seat) -> str:
    """Say that it listens, to whom, and what to do first."""
    sources = [f"the microphone {microphone}"]
    sources += ["typed commands"] if somebody_types() else []
    sources += ["another recognizer"] if seat.also else []
    first = "" if seat.listening else '; say "start speech" first'
    return f"listening to {' and '.join(sources)}{first}"
