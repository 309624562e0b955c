"""Parts that any run may have; each opens one thing, and connects it to the session."""

from __future__ import annotations

from collections.abc import Callable, Collection, Iterator, Sequence
from contextlib import AbstractContextManager, contextmanager
from dataclasses import replace
from functools import partial
from typing import Protocol

from msgspec.structs import replace as replace_fields

from voz.events import Attention, Event, Partial, Play, ProgramEnded, Receiver, Reply, Utterance
from voz.inbox import Inbox
from voz.run.clocks import Clock, PacedClock, RecordedClock, Source, pace
from voz.run.dispatcher import QueuedReceiver
from voz.run.programs import Programs
from voz.run.session import Session
from voz.run.spec import Part, RunSpec
from voz.settings import Speech
from voz.speech.reply_speaker import ReplySpeaker


@contextmanager
def write_events(
    session: Session, name: str, opening: AbstractContextManager[Receiver]
) -> Iterator[None]:
    """Write all events somewhere, behind a queue where the run has a clock."""
    if session.in_real_time:
        opening = QueuedReceiver(name, opening, session.inbox.put)
    with opening as receive:
        session.receivers.append(receive)
        yield


@contextmanager
def speak_replies(session: Session, interruptible: bool = True) -> Iterator[None]:
    """Say replies and play sounds; `interruptible` falls silent where somebody stops the robot."""
    settings = session.spec.settings.speech
    if not settings.enabled:
        yield
        return
    with open_speaker(settings, session.table.replies, session.warn) as speaker:
        session.speaker = speaker
        session.receivers.append(speaker_receiver(speaker, session.table.halts, interruptible))
        yield


@contextmanager
def open_speaker(
    settings: Speech, replies: Sequence[str], warn: Callable[[str], None]
) -> Iterator[ReplySpeaker]:
    """Open a speaker for a `with` block; `replies` are rendered beforehand."""
    with ReplySpeaker(settings.voice, replies, warn) as speaker:
        speaker.mixer.barge_in = settings.barge_in
        yield speaker


def speaker_receiver(
    speaker: ReplySpeaker, halts: Collection[str], interruptible: bool = True
) -> Receiver:
    """Return a receiver that lets a speaker say replies, play sounds, and fall silent.

    It does at what may be a command in `halts`, and with `barge_in` at any that is obeyed.
    """

    def interrupts(event: Partial | Utterance) -> bool:
        if isinstance(event, Partial):
            return event.name in halts
        return bool(event.obeyed) and (event.name in halts or speaker.mixer.barge_in)

    def receive(event: Event) -> None:
        if isinstance(event, Reply):
            speaker.say(event.text)
        elif isinstance(event, Play):
            speaker.play(event.sound)
        elif isinstance(event, Partial | Utterance) and interruptible and interrupts(event):
            speaker.interrupt()

    return receive


@contextmanager
def start_programs(session: Session) -> Iterator[Programs]:
    """Start programs and functions; raises ConfigError if one does not exist."""
    in_time = session.in_real_time

    def report(ended: ProgramEnded) -> None:
        session.report(replace_fields(ended, t=session.clock.now()) if in_time else ended)

    with Programs(session.table, report, session.show, wait=not in_time) as programs:
        session.receivers.append(programs.receive)
        yield programs


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
def hear_answers(session: Session, recognizer: Answerable) -> Iterator[None]:
    """Let a recognizer understand answers to what the robot asks."""
    session.receivers.append(answer_receiver(recognizer))
    yield


def by_items(
    spec: RunSpec, source: Source, parts: Sequence[Part] = (), *, in_real_time: bool
) -> RunSpec:
    """Return a run by recordings, lines or a bag; the parts come besides the voice and programs.

    In real time it is paced by the real clock, for robots that need it; else there is no clock but
    that of the source, and the events are the same each time.
    """
    own: list[Part] = [partial(speak_replies, interruptible=False), start_programs, *parts]
    if in_real_time:
        return replace(spec, clock=PacedClock, parts=[*own, partial(_pace, source=source)])

    def clock(_: Inbox) -> Clock:
        return RecordedClock(source(lambda: 0.0))

    return replace(spec, clock=clock, in_real_time=False, parts=own)


@contextmanager
def _pace(session: Session, source: Source) -> Iterator[None]:
    assert isinstance(session.clock, PacedClock)
    with pace(source(session.clock.exactly), session.inbox, session.clock):
        yield
