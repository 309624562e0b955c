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
from voz.texts import language_of, list_texts, text

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

    def serving(self, session: Session) -> AbstractContextManager[SpeechInput]:
        """Serve it for a `with` block; yields what to watch in place of the microphone."""


class CommandService(Protocol):
    """Takes commands of other programs, whose users do not watch the robot."""

    source: str  # of the commands

    def receive(self, event: Event) -> None:
        """Take an event; it never waits."""

    def serving(self) -> AbstractContextManager[None]:
        """Serve for a `with` block."""


@contextmanager
def drive_live(
    session: Session,
    recognizer: RecognitionEngine,
    sound: SoundSource,
    *,
    page: Callable[[Session], Page] | None = None,
    service: Callable[[Session, Callable[[], bool]], CommandService] | None = None,
    other_recognizer: OtherRecognizer | None = None,
    record: RecorderOpener | None = None,
    settings_file: SettingsFile | None = None,
    terminal: LiveTerminal | None = None,
    announce: Callable[[str], None] = lambda _: None,
) -> Iterator[None]:
    """Let a microphone, the keyboard, a page and other programs drive: a part of a live run.

    `sound` is what is listened to, where it is not a page's browser. `service` makes what takes
    commands of other programs, given what returns whether somebody drives from the page. The
    settings file may change during the run. `announce` takes the line that says what is listened
    to, where there is no display.

    Raises:
        AudioError: there is no such microphone.
    """
    settings, controller = session.spec.settings, session.controller
    with ExitStack() as opened:
        enter = opened.enter_context
        shown = page(session) if page else None
        session.recognizer = recognizer
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
            recognizer, settings, settings_file, programs.add, session.inbox,
            session.clock,
        )  # fmt: skip
        enter(reload.watching())
        enter(hear_answers(session, recognizer))
        if service:
            served = service(session, lambda: bool(shown and shown.driven))
            session.add_unwatched(served.source)
            session.receivers.append(served.receive)
            enter(served.serving())
        if terminal:
            display = _display(session, hearing, line)
            session.receivers.append(display.receive)
            enter(terminal.live(display.__rich__))
        else:
            others = [
                *(["another recognizer"] if other_recognizer else []),
                *(["Wyoming clients"] if service else []),
            ]
            announce(_listening_line(session, hearing, others))
        if shown:
            session.receivers.append(shown.receive)
            session.add_unwatched(shown.unwatched_source)
            session.watch(PAGE, lambda: shown.trouble(controller.moving), *shown.sources)
        session.watch_input(enter(shown.serving(session)) if shown else hearing)
        yield


def _sound(session: Session, sound: SoundSource, page: Page | None) -> SoundSource:
    """Return a page's browser or another sound, with the playback that it may pick up."""
    own = session.speaker.mixer if session.speaker else None
    own = own if session.spec.settings.speech.half_duplex else None
    sound = (page.sound if page else None) or sound
    return replace(sound, playback=page.audible_playback(own) if page else own)


def _display(session: Session, hearing: Hearing, line: TypedLine) -> Display:
    recorder = session.recorder
    return Display(
        hearing,
        session.controller,
        lambda: line.text,
        lambda: recorder.note if recorder else "",
        session.view,
        language_of(session.spec.settings.language.name),
    )


def _listening_line(session: Session, hearing: Hearing, others: Sequence[str]) -> str:
    """Say what is listened to, and what begins that."""
    language = language_of(session.spec.settings.language.name)
    microphone = text("the microphone {name}", language, name=hearing.device)
    sources = [] if hearing.device == NO_MICROPHONE else [microphone]
    typed = ["typed commands"] if can_read_input() else []
    sources += [text(other, language) for other in (*typed, *others)]
    listed = list_texts("{one} and {other}", sources, language)
    listening = text("listening to {sources}", language, sources=listed)
    if session.spec.listening:
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
