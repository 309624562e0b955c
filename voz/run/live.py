"""The parts of a live run: a microphone, typed commands, a page and other programs drive."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from contextlib import AbstractContextManager, ExitStack, contextmanager
from dataclasses import replace
from typing import Protocol, TypeAlias

from voz.control.messages import Halt
from voz.events import Event
from voz.hearing.half_duplex import Playback
from voz.hearing.microphone_thread import NO_MICROPHONE, Hearing, SoundRecorder, SoundSource
from voz.recognition.engine import RecognitionEngine
from voz.run.command_reload import CommandReload, SettingsFile
from voz.run.parts import hear_answers, speak_replies, start_programs
from voz.run.session import Session, SpeechInput
from voz.run.sources import TextCommands
from voz.terminal.display import Display
from voz.terminal.keyboard import TypedLine, can_read_input, read_keyboard
from voz.terminal.live_terminal import LiveTerminal
from voz.texts import list_texts, text

PAGE = "the operator's page"

TakeText: TypeAlias = Callable[[str, str], None]
"""Obeys a sentence; the second argument is its source."""

OtherRecognizer: TypeAlias = Callable[
    [TakeText, Callable[[str], None]], AbstractContextManager[None]
]
"""Opens another recognizer, given what obeys it, and what takes the reason of its loss."""

RecorderOpener: TypeAlias = Callable[[Callable[[str], None]], AbstractContextManager[SoundRecorder]]
"""Opens what keeps what is heard, given what takes its warnings."""


class Page(Protocol):
    """A page that shows the run and drives the robot."""

    unwatched_source: str  # of the commands of programs that do not show whether they are there

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

    def serving(self) -> AbstractContextManager[SpeechInput]:
        """Serve it for a `with` block; yields what to watch in place of the microphone."""


class CommandService(Protocol):
    """Takes commands of other programs, whose users do not watch the robot."""

    source: str  # of the commands

    def receive(self, event: Event) -> None:
        """Take an event; it never waits."""

    def serving(self) -> AbstractContextManager[None]:
        """Serve for a `with` block."""


ServiceMaker: TypeAlias = Callable[[Session, Callable[[], bool]], CommandService]
"""Makes what takes commands of other programs, given what returns whether a page is driven from."""


@contextmanager
def drive_live(
    session: Session,
    recognizer: RecognitionEngine,
    sound: SoundSource,
    *,
    page: Callable[[Session], Page] | None = None,
    service: ServiceMaker | None = None,
    other_recognizer: OtherRecognizer | None = None,
    record: RecorderOpener | None = None,
    settings_file: SettingsFile | None = None,
    terminal: LiveTerminal | None = None,
    announce: Callable[[str], None] = lambda _: None,
) -> Iterator[None]:
    """Let a microphone, the keyboard, a page and other programs drive: a part of a live run.

    `sound` is what is listened to, where it is not a page's browser. The settings file may change
    during the run. `announce` takes the line that says what is listened to, where there is no
    display.

    Raises:
        AudioError: there is no such microphone.
    """
    settings = session.spec.settings
    with ExitStack() as opened:
        enter = opened.enter_context
        session.recognizer = recognizer
        shown = page(session) if page else None
        session.recorder = enter(record(session.warn)) if record else None
        enter(speak_replies(session))
        hearing = session.hearing = enter(
            Hearing(
                recognizer, _sound(session, sound, shown), session.inbox, session.clock.now,
                session.recorder, never_missed=settings.recognition.never_missed,
            )
        )  # fmt: skip
        line = enter(_text_commands(session, recognizer, other_recognizer))
        programs = enter(start_programs(session))
        reload = CommandReload(
            recognizer, settings, settings_file, programs.add,
            inbox=session.inbox, clock=session.clock,
        )  # fmt: skip
        enter(reload.watching())
        enter(hear_answers(session, recognizer))
        if service:
            enter(_other_programs(session, service, shown))
        if terminal:
            enter(_displayed(session, hearing, line, terminal))
        else:
            others = {"another recognizer": other_recognizer, "Wyoming clients": service}
            listed = [name for name, given in others.items() if given]
            announce(_listening_line(session, hearing, listed))
        session.watch_input(enter(_serving(session, shown)) if shown else hearing)
        yield


@contextmanager
def _other_programs(session: Session, service: ServiceMaker, page: Page | None) -> Iterator[None]:
    """Obey other programs, whose users do not watch the robot, for a `with` block."""
    served = service(session, lambda: bool(page and page.driven))
    session.add_unwatched(served.source)
    session.receivers.append(served.receive)
    with served.serving():
        yield


def _serving(session: Session, page: Page) -> AbstractContextManager[SpeechInput]:
    """Show the run on a page, and watch whether the one who drives there is gone."""
    session.receivers.append(page.receive)
    session.add_unwatched(page.unwatched_source)
    controller = session.controller
    session.watch(PAGE, lambda: page.trouble(controller.moving), *page.sources)
    return page.serving()


def _sound(session: Session, sound: SoundSource, page: Page | None) -> SoundSource:
    """Return a page's browser or another sound, with the playback that it may pick up."""
    own = session.speaker.mixer if session.speaker else None
    own = own if session.spec.settings.speech.half_duplex else None
    sound = (page.sound if page else None) or sound
    return replace(sound, playback=page.audible_playback(own) if page else own)


@contextmanager
def _displayed(
    session: Session, hearing: Hearing, line: TypedLine, terminal: LiveTerminal
) -> Iterator[None]:
    """Draw the run in a terminal for a `with` block."""
    recorder = session.recorder
    display = Display(
        hearing,
        session.controller,
        lambda: line.text,
        lambda: recorder.note if recorder else "",
        extra=session.view,
        language=session.language,
    )
    session.receivers.append(display.receive)
    with terminal.live(display.__rich__):
        yield


def _listening_line(session: Session, hearing: Hearing, others: Sequence[str]) -> str:
    """Say what is listened to, and what begins that."""
    language = session.language
    microphone = text("the microphone {name}", language, name=hearing.device)
    sources = [] if hearing.device == NO_MICROPHONE else [microphone]
    typed = ["typed commands"] if can_read_input() else []
    sources += [text(other, language) for other in (*typed, *others)]
    listed = list_texts("{one} and {other}", sources, language)
    listening = text("listening to {sources}", language, sources=listed)
    if session.controller.listening:
        return listening
    first = '{listening}; say "{command}" first'
    return text(first, language, listening=listening, command=session.controller.wake)


@contextmanager
def _text_commands(
    session: Session, recognizer: RecognitionEngine, other_recognizer: OtherRecognizer | None
) -> Iterator[TypedLine]:
    """Take commands from the keyboard and another recognizer; gives the line being typed."""
    texts = TextCommands(lambda: recognizer.commands, session.inbox, session.clock.now)

    def stop() -> None:
        session.inbox.put(Halt(t=session.clock.now()))

    def stop_unheard(why: str) -> None:
        stop()
        session.warn(f"{why}: the robot stops")

    with read_keyboard(stop, texts.take, texts.continues, session.warn) as line, ExitStack() as own:
        if other_recognizer:
            own.enter_context(other_recognizer(texts.take, stop_unheard))
        yield line
