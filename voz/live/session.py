"""Puts the live parts together: what a launch file does."""

from __future__ import annotations

import sys
import time
from collections.abc import Callable, Collection, Iterator, Mapping, Sequence
from contextlib import AbstractContextManager, ExitStack, contextmanager, suppress
from pathlib import Path
from typing import NoReturn, TypeAlias

from rich.console import Console, RenderableType
from rich.live import Live

from voz.config import Config
from voz.control.controller import REPLIES
from voz.control.safety import zero_at_the_end
from voz.drive import SWITCH, Drive
from voz.events import Event, Receiver, Warning
from voz.language.commands import normalise
from voz.live.display import Display
from voz.live.hearing import Hearing
from voz.live.keyboard import keys
from voz.live.loop import drive_live, stamp
from voz.live.messages import Inbox
from voz.live.recorder import Recorder
from voz.pipeline import NO_COMMAND, TYPED, replies_to, typed
from voz.recognition.recognizer import Recognizer
from voz.speech.speaker import Speaker
from voz.watch import over_robots

REDRAWN = 5
"""Times a second that a terminal is drawn anew; more costs a small computer too much."""

Typist: TypeAlias = Callable[[str, str], None]
"""Obeys a sentence; the second is its source."""


def run_live(
    receivers: Sequence[Receiver],
    settings: Config,
    recognizer: Recognizer,
    commands: Collection[str],
    inbox: Inbox,
    device: str | None = None,
    listening: bool = False,
    terminal: Console | None = None,
    record: Path | None = None,
    lost: Mapping[str, Callable[[], str | None]] | None = None,
    extra: RenderableType | None = None,
    also: Callable[[Typist], AbstractContextManager[None]] | None = None,
) -> NoReturn:
    """Drive a robot by a microphone and the keyboard until a signal ends the program.

    Args:
        receivers: called with every event, in order.
        settings: the safety rules and the voice.
        recognizer: what understands.
        commands: the sentences that may be typed.
        inbox: what is heard goes through it; others may warn of something by it.
        device: the microphone's number or a part of its name; None is the default one.
        listening: whether commands are obeyed before a `start speech`.
        terminal: draws the display, if there is somebody to see it.
        record: the folder in which what is heard is kept.
        lost: tells of each robot, by its name, why it is lost (S5).
        extra: what the terminal shows besides.
        also: another recogniser, which is given what obeys a sentence from a source.

    Raises:
        AudioError: there is no such microphone.
    """
    sys.setswitchinterval(SWITCH)
    begun = time.monotonic()

    def clock() -> float:
        return time.monotonic() - begun

    def obey(line: str, source: str = TYPED) -> None:
        text = normalise(line)
        if text not in NO_COMMAND:
            inbox.put(typed(text, text in commands, stamp(clock()), source))

    def warn(text: str) -> None:
        inbox.put(Warning(stamp(clock()), text))

    voice = settings.speech.voice if settings.speech.enabled else None
    with ExitStack() as parts:
        recorder = None
        if record:
            recorder = parts.enter_context(Recorder(record, settings.recording.gigabytes, warn))
        speaker = parts.enter_context(Speaker(voice, REPLIES)) if voice else None
        half_duplex = speaker is not None and settings.speech.half_duplex
        hearing = Hearing(
            recognizer,
            device,
            inbox,
            clock,
            loudspeaker=speaker.mixer if speaker and half_duplex else None,
            never_missed=settings.recognition.never_missed,
            recorder=recorder,
        )
        parts.enter_context(hearing)
        line = parts.enter_context(keys(inbox, obey))
        if also:
            parts.enter_context(also(obey))
        told = [*receivers, *([answers(speaker, warn)] if speaker else [])]
        if terminal:
            display = Display(
                lambda: hearing.peak,
                lambda: drive.listening,
                lambda: line.text,
                hearing.device,
                lambda: recorder.note if recorder else "",
                extra,
            )
            told.append(display.receive)
        drive = Drive(told, settings.safety, listening)
        if terminal:
            parts.enter_context(drawn(display, terminal))
        parts.enter_context(zero_at_the_end(lambda: drive.zero(stamp(clock()))))
        drive_live(drive, inbox, hearing.trouble, clock, over_robots(drive, lost or {}))


def answers(speaker: Speaker, warn: Callable[[str], None]) -> Receiver:
    """Make a receiver that lets a speaker say the replies, and tells what goes wrong with that."""
    say = replies_to(speaker)

    def receive(event: Event) -> None:
        say(event)
        for problem in speaker.drain_warnings():
            warn(problem)

    return receive


@contextmanager
def drawn(display: Display, terminal: Console) -> Iterator[None]:
    """Draw a display anew, again and again, for the length of a `with` block."""
    live = Live(get_renderable=display.__rich__, console=terminal, refresh_per_second=REDRAWN)
    live.start()
    try:
        yield
    finally:
        with suppress(OSError):  # the terminal was closed, which is why it ends
            live.stop()
