"""Parts that any run may have; each opens one thing, and connects it to the session."""

from __future__ import annotations

import queue
import threading
import time
from collections.abc import Callable, Collection, Iterable, Iterator, Sequence
from contextlib import AbstractContextManager, contextmanager, suppress
from dataclasses import replace
from functools import partial
from typing import TYPE_CHECKING

from msgspec.structs import replace as replace_fields

from voz.control.messages import End
from voz.events import (
    Attention,
    Event,
    Notice,
    Partial,
    Play,
    ProgramEnded,
    Receiver,
    Reply,
    Utterance,
    shift_time,
)
from voz.inbox import Inbox
from voz.records import check_type
from voz.run.clocks import Clock, PacedClock, RecordedClock, Source, pace
from voz.run.programs import Programs
from voz.run.session import Session
from voz.run.spec import Part, RunSpec
from voz.speech.reply_speaker import ReplySpeaker

if TYPE_CHECKING:
    from voz.recognition.engine import RecognitionEngine

MAX_QUEUED_EVENTS = 6000
"""Waiting for a slow disk or reader: ten minutes of events."""

EVENT_FLUSH_TIMEOUT = 3.0
"""To write what waits when the run is over, s; some readers never read it."""


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


class QueuedReceiver:
    """Hands events to a receiver that may be slow, without waiting for it.

    The `with` block opens the receiver; its end writes what is queued and closes it. An error of
    the receiver ends the run; if the run is over already, the block raises it.
    """

    def __init__(
        self,
        name: str,
        opening: AbstractContextManager[Receiver],
        report: Callable[[Notice | End], None],
    ) -> None:
        """Prepare a queue for a receiver that is opened and left on the other thread.

        `report` takes the warning that it is too slow, and the end of the run by an error; messages
        name what is written.
        """
        self._name = name
        self._opening = opening
        self._report = report
        self._waiting: queue.Queue[Event | None] = queue.Queue(MAX_QUEUED_EVENTS)
        self._opened = threading.Event()
        self._failure: Exception | None = None
        self._warned = False
        self._thread = threading.Thread(target=self._work, name="voz-queued", daemon=True)

    def __enter__(self) -> Receiver:
        """Open the receiver; raises what that raises."""
        self._thread.start()
        self._opened.wait()
        if self._failure:
            raise self._failure
        return self._receive

    def __exit__(self, kind: type[BaseException] | None, *_: object) -> None:
        if not self._failure:
            with suppress(queue.Full):
                self._waiting.put(None, timeout=EVENT_FLUSH_TIMEOUT)
                self._thread.join(EVENT_FLUSH_TIMEOUT)
        if kind is None and self._failure:
            raise self._failure

    def _receive(self, event: Event) -> None:
        try:
            self._waiting.put_nowait(event)
        except queue.Full:
            if not self._warned and not self._failure:
                self._warned = True
                text = f"{self._name}: cannot be written fast enough; events are missing"
                self._report(Notice(event.t, text))

    def _work(self) -> None:
        try:
            with self._opening as write:
                self._opened.set()
                while (event := self._waiting.get()) is not None:
                    write(event)
        except BaseException as error:  # it ends the run, which sends the events
            self._failure = error if isinstance(error, Exception) else RuntimeError(repr(error))
            if self._opened.is_set():
                self._report(End(self._failure))
        finally:
            self._opened.set()


@contextmanager
def speak_replies(session: Session, interruptible: bool = True) -> Iterator[None]:
    """Say replies and play sounds; `interruptible` falls silent where somebody stops the robot."""
    settings = session.spec.settings.speech
    if not settings.enabled:
        yield
        return
    replies, barge_in = session.table.replies, settings.barge_in
    with ReplySpeaker(settings.voice, replies, session.warn, barge_in=barge_in) as speaker:
        session.speaker = speaker
        session.receivers.append(speaker_receiver(speaker, session.table.halts, interruptible))
        yield


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


def answer_receiver(recognizer: RecognitionEngine) -> Receiver:
    """Return a receiver that lets a recognizer understand answers to what the robot asks."""

    def receive(event: Event) -> None:
        if isinstance(event, Attention):
            recognizer.expect(event.answers)

    return receive


@contextmanager
def hear_answers(session: Session, recognizer: RecognitionEngine) -> Iterator[None]:
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


@contextmanager
def take_utterances(session: Session, heard: Iterable[Utterance | Partial]) -> Iterator[None]:
    """Let what is heard drive, and its end or an error end the run; a thread waits for it."""
    threading.Thread(
        target=_forward, args=(heard, session.inbox, session.clock), daemon=True
    ).start()
    yield


def _forward(heard: Iterable[Utterance | Partial], inbox: Inbox, clock: Clock) -> None:
    try:
        for event in heard:
            check_type((Utterance, Partial), event, "heard")
            inbox.put(shift_time(event, clock.now() - event.t))
    except BaseException as error:  # `sys.exit` and a cancelled task, too: nobody commands any more
        inbox.put(End(error))
    else:
        while not inbox.is_empty:  # the end would overtake what was heard
            time.sleep(0.01)
        inbox.put(End())
