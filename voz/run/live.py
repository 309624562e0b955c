"""A run by a microphone and the keyboard, with its sources and receivers."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from contextlib import AbstractContextManager, ExitStack, contextmanager, nullcontext
from dataclasses import dataclass, replace
from functools import partial
from typing import TYPE_CHECKING, Protocol, TypeAlias

from voz.config import Config
from voz.control.messages import Halt
from voz.events import Event
from voz.hearing.half_duplex import Playback
from voz.hearing.microphone_thread import Hearing, SoundRecorder, SoundSource, sound_card
from voz.inbox import Inbox
from voz.recognition.engine import RecognitionEngine
from voz.run.clocks import Clock, WallClock
from voz.run.command_reload import CommandReload, SettingsFile
from voz.run.dispatcher import Dispatcher
from voz.run.session import (
    OpenRobots,
    Session,
    SpeechInput,
    answer_receiver,
    interruption_receivers,
    new_session,
    open_programs,
    open_speaker,
    speech_receivers,
    warner,
)
from voz.run.text_commands import TextCommands
from voz.terminal.display import Display
from voz.terminal.keyboard import TypedLine, can_read_input, read_keyboard
from voz.terminal.live_terminal import LiveTerminal

if TYPE_CHECKING:
    from voz.robot.simulation.room_view import RoomView

PAGE = "the operator's page"

TakeText: TypeAlias = Callable[[str, str], None]
"""Obeys a sentence; the second argument is its source."""

OtherRecognizer: TypeAlias = Callable[
    [TakeText, Callable[[str], None]], AbstractContextManager[None]
]
"""Opens another recognizer, given what obeys it, and what takes the reason of its loss."""


class Page(Protocol):
    """A page that shows the run and drives the robot.

    Attributes:
        unwatched_source: of the commands of programs that do not show whether they are there.
    """

    unwatched_source: str

    @property
    def sources(self) -> Sequence[str]:
        """The sources of the commands of the page that drives."""

    @property
    def sound(self) -> SoundSource | None:
        """Its browser as a microphone; None if the robot's own is used."""

    @property
    def driven(self) -> bool:
        """Whether somebody drives from it."""

    def audible_playback(self, own: Playback | None) -> Playback:
        """All playback that a microphone may pick up: the robot's and the browsers'."""

    def receive(self, event: Event) -> None:
        """Take an event; it never waits."""

    def trouble(self, moving: bool) -> str | None:
        """Return why it does not drive any more, if that matters."""

    def serving(self, parts: RunParts) -> AbstractContextManager[SpeechInput]:
        """Serve it for a `with` block; yields what to watch in place of the microphone."""


class CommandService(Protocol):
    """Takes commands of other programs, whose users do not watch the robot.

    Attributes:
        source: of the commands.
    """

    source: str

    def receive(self, event: Event) -> None:
        """Take an event; it never waits."""

    def serving(self) -> AbstractContextManager[None]:
        """Serve for a `with` block."""


CommandServiceMaker: TypeAlias = Callable[[Inbox, Clock, Callable[[], bool]], CommandService]
"""Makes one, given what returns whether somebody drives from the page."""


@dataclass(frozen=True)
class RunParts:
    """What a page shows of a run.

    Attributes:
        mixer: plays what the robot says; None if it is silent.
        recorder: keeps what is heard; None without `--record`.
    """

    controller: Dispatcher
    hearing: Hearing
    mixer: Playback | None
    recognizer: RecognitionEngine
    settings: Config
    recorder: SoundRecorder | None


@dataclass(frozen=True)
class LiveOptions:
    """Options of a live run.

    Attributes:
        device: the microphone's number or a part of its name; None is the default one.
        sound: what is listened to in place of that.
        listening: whether commands are obeyed before a `start speech`.
        terminal: draws the display, if there is somebody to see it.
        announce: takes the line that says what is listened to, where there is no display.
        record: opens the recorder of what is heard, given what takes its warnings.
        other_recognizer: opens another recognizer, which is obeyed, too.
        settings_file: where the settings are, which may change during the run.
        page: makes a page that shows the run, given the inbox and the clock.
        service: makes what takes commands of other programs.
    """

    device: str | None = None
    sound: SoundSource | None = None
    listening: bool = False
    terminal: LiveTerminal | None = None
    announce: Callable[[str], None] = lambda _: None
    record: Callable[[Callable[[str], None]], AbstractContextManager[SoundRecorder]] | None = None
    other_recognizer: OtherRecognizer | None = None
    settings_file: SettingsFile | None = None
    page: Callable[[Inbox, Clock], Page] | None = None
    service: CommandServiceMaker | None = None


def run_live(
    settings: Config,
    recognizer: RecognitionEngine,
    inbox: Inbox,
    robots: OpenRobots,
    options: LiveOptions,
) -> None:
    """Drive a robot by a microphone and the keyboard until a signal ends the program.

    Raises:
        AudioError: there is no such microphone.
    """
    clock = WallClock(inbox)
    warn = warner(inbox, clock)
    session = new_session(settings, clock, options.listening)
    table = session.table
    never_missed = settings.recognition.never_missed
    unwatched: list[str] = []
    with ExitStack() as parts:
        enter = parts.enter_context
        page = options.page(inbox, clock) if options.page else None
        recorder = enter(options.record(warn) if options.record else nullcontext())
        speaker = enter(open_speaker(settings.speech, table.replies, warn))
        mixer = speaker.mixer if speaker else None
        sound = _sound_source(options, page, mixer if settings.speech.half_duplex else None)
        hearing = enter(
            Hearing(recognizer, sound, inbox, clock.now, recorder, never_missed=never_missed)
        )
        line = enter(_text_commands(recognizer, inbox, clock, options.other_recognizer))
        programs = enter(open_programs(table, inbox, clock, robots.show))
        reload = CommandReload(
            recognizer, settings, options.settings_file, programs.add, inbox, clock
        )
        enter(reload.watching())
        session.add_robots(robots)
        session.receivers += [*interruption_receivers(speaker, table.halts)]
        session.receivers += [*speech_receivers(speaker), programs.receive]
        if page:
            unwatched.append(page.unwatched_source)
            session.receivers.append(page.receive)
        session.receivers.append(answer_receiver(recognizer))
        if options.service:
            service = options.service(inbox, clock, lambda: bool(page and page.driven))
            unwatched.append(service.source)
            session.receivers.append(service.receive)
            enter(service.serving())
        session.change_rules(unwatched_sources=frozenset(unwatched))
        shown = RunParts(session.controller, hearing, mixer, recognizer, settings, recorder)
        enter(
            _show_on_terminal(_display(shown, line, robots.view), session, options, hearing.device)
        )
        if page:
            session.watch({PAGE: partial(_trouble, page, session.controller)}, *page.sources)
        session.watch_input(enter(page.serving(shown)) if page else hearing)
        session.run_in_real_time(inbox)


def _sound_source(options: LiveOptions, page: Page | None, own: Playback | None) -> SoundSource:
    """Return a page's browser or the sound card, with the playback that it may pick up."""
    sound = (page.sound if page else None) or options.sound or sound_card(options.device)
    return replace(sound, playback=page.audible_playback(own) if page else own)


@contextmanager
def _text_commands(
    recognizer: RecognitionEngine,
    inbox: Inbox,
    clock: Clock,
    other_recognizer: OtherRecognizer | None,
) -> Iterator[TypedLine]:
    """Take commands from the keyboard and another recognizer; gives the line being typed."""
    texts = TextCommands(lambda: recognizer.commands, inbox, clock.now)
    stop, warn = partial(_stop, inbox, clock), warner(inbox, clock)
    with read_keyboard(stop, texts.take, texts.continues, warn) as line, ExitStack() as opened:
        if other_recognizer:
            lost = partial(_stop_unheard, inbox, clock)
            opened.enter_context(other_recognizer(texts.take, lost))
        yield line


def _display(shown: RunParts, line: TypedLine, view: RoomView | None) -> Display:
    recorder = shown.recorder
    return Display(
        shown.hearing,
        shown.controller,
        lambda: line.text,
        lambda: recorder.note if recorder else "",
        view,
    )


def _stop(inbox: Inbox, clock: Clock) -> None:
    inbox.put(Halt(t=clock.now()))


def _stop_unheard(inbox: Inbox, clock: Clock, why: str) -> None:
    _stop(inbox, clock)
    warner(inbox, clock)(f"{why}: the robot stops")


def _trouble(page: Page, controller: Dispatcher) -> str | None:
    return page.trouble(controller.moving)


@contextmanager
def _show_on_terminal(
    display: Display, session: Session, options: LiveOptions, microphone: str
) -> Iterator[None]:
    """Draw the run on the terminal in a `with` block; without one, announce that it begins."""
    if options.terminal is None:
        options.announce(_ready_line(microphone, options))
        yield
        return
    session.receivers.append(display.receive)
    with options.terminal.live(display.__rich__):
        yield


def _ready_line(microphone: str, options: LiveOptions) -> str:
    sources = [] if options.sound else [f"the microphone {microphone}"]
    sources += ["typed commands"] if can_read_input() else []
    sources += ["another recognizer"] if options.other_recognizer else []
    sources += ["Wyoming clients"] if options.service else []
    first = "" if options.listening else '; say "start speech" first'
    return f"listening to {' and '.join(sources)}{first}"
