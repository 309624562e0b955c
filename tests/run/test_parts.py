"""What makes the robot speak and what silences it; receivers that may be slow."""

from __future__ import annotations

import queue
import threading
from collections.abc import Iterator
from contextlib import contextmanager
from typing import cast

import pytest
from programs import PATIENCE

from voz.control.messages import End
from voz.errors import ConfigError
from voz.events import Event, Notice, Partial, Play, Receiver, Reply, Twist, Utterance
from voz.run.parts import MAX_QUEUED_EVENTS, QueuedReceiver, speaker_receiver
from voz.speech.reply_speaker import ReplySpeaker


class Voice:
    """A speaker that keeps what it is to do."""

    def __init__(self, barge_in: bool) -> None:
        self.mixer = self
        self.barge_in = barge_in
        self.done: list[str] = []

    def say(self, text: str) -> None:
        self.done.append(f"say {text}")

    def play(self, sound: str) -> None:
        self.done.append(f"play {sound}")

    def interrupt(self) -> None:
        self.done.append("fall silent")


def done(event: Event, barge_in: bool = False, interruptible: bool = True) -> list[str]:
    voice = Voice(barge_in)
    speaker_receiver(cast(ReplySpeaker, voice), {"stop", "halt"}, interruptible)(event)
    return voice.done


def utterance(text: str, obeyed: bool) -> Utterance:
    return Utterance(2.0, text, 1.0, True, 1.0, 1.8, "microphone", obeyed=obeyed)


def test_replies_are_said_and_sounds_played() -> None:
    assert done(Reply(1.0, "hello")) == ["say hello"]
    assert done(Play(1.0, "beep.wav")) == ["play beep.wav"]


@pytest.mark.parametrize(
    ("event", "always", "with_barge_in"),
    [
        (Partial(1.0, "please stop", 0.6, "stop"), True, True),
        (Partial(1.0, "go forward", 0.9), False, False),
        (utterance("halt", obeyed=True), True, True),
        (utterance("go forward", obeyed=True), False, True),
        (utterance("stop", obeyed=False), False, False),
        (utterance("go forward", obeyed=False), False, False),
    ],
)
def test_what_stops_silences_it_and_with_barge_in_every_command_that_is_obeyed(
    event: Event, always: bool, with_barge_in: bool
) -> None:
    assert (done(event) == ["fall silent"]) is always
    assert (done(event, barge_in=True) == ["fall silent"]) is with_barge_in
    assert done(event, barge_in=True, interruptible=False) == []


class Log:
    """Keeps events; stalls while `flows` is not set, and fails at the event of `fails_at`."""

    def __init__(self, fails_at: float | None = None) -> None:
        self.flows = threading.Event()
        self.flows.set()
        self.begun = threading.Event()
        self.times: list[float] = []
        self.closed_on = ""
        self._fails_at = fails_at

    @contextmanager
    def opening(self) -> Iterator[Receiver]:
        try:
            yield self._write
        finally:
            self.closed_on = threading.current_thread().name

    def _write(self, event: Event) -> None:
        self.begun.set()
        self.flows.wait()
        if event.t == self._fails_at:
            raise ConfigError("log: cannot be written (No space left on device)")
        self.times.append(event.t)


def twist(t: float) -> Twist:
    return Twist(t, 0.1, 0.0)


def test_all_events_are_written_in_order_before_it_is_closed() -> None:
    log = Log()
    with QueuedReceiver("log", log.opening(), pytest.fail) as receive:
        for number in range(200):
            receive(twist(number))
    assert log.times == list(range(200))
    assert log.closed_on == "voz-queued"


def test_who_sends_does_not_wait_and_is_warned_once() -> None:
    log = Log()
    log.flows.clear()
    told: list[Notice | End] = []
    with QueuedReceiver("log", log.opening(), told.append) as receive:
        receive(twist(0))
        assert log.begun.wait(PATIENCE)  # that one is stuck, and the others wait
        for number in range(1, MAX_QUEUED_EVENTS + 3):
            receive(twist(number))
        text = "log: cannot be written fast enough; events are missing"
        assert told == [Notice(MAX_QUEUED_EVENTS + 1, text)]
        log.flows.set()
    assert log.times == list(range(MAX_QUEUED_EVENTS + 1))


def test_what_it_raises_ends_the_run_and_who_sends_goes_on() -> None:
    log = Log(fails_at=0)
    told: queue.SimpleQueue[Notice | End] = queue.SimpleQueue()
    queued = QueuedReceiver("log", log.opening(), told.put)
    receive = queued.__enter__()
    receive(twist(0))
    end = told.get(timeout=PATIENCE)
    assert isinstance(end, End)
    assert "No space left" in str(end.error)
    for number in range(MAX_QUEUED_EVENTS + 3):
        receive(twist(number))
    assert told.empty()
    with pytest.raises(ConfigError, match="No space left"):
        queued.__exit__(None, None, None)


def test_an_error_that_ended_the_run_is_not_hidden_by_another_at_its_end() -> None:
    log = Log(fails_at=0)
    told: queue.SimpleQueue[Notice | End] = queue.SimpleQueue()
    queued = QueuedReceiver("log", log.opening(), told.put)
    queued.__enter__()(twist(0))
    told.get(timeout=PATIENCE)
    queued.__exit__(RuntimeError, RuntimeError(), None)


def test_what_it_raises_last_is_raised_at_the_end() -> None:
    log = Log(fails_at=2)
    queued = QueuedReceiver("log", log.opening(), lambda _: None)
    receive = queued.__enter__()
    receive(twist(1))
    receive(twist(2))
    with pytest.raises(ConfigError, match="No space left"):
        queued.__exit__(None, None, None)
    assert log.times == [1]


def test_what_opening_raises_is_raised_at_once() -> None:
    @contextmanager
    def closed() -> Iterator[Receiver]:
        raise ConfigError("none/log: cannot be written (No such file or directory)")
        yield

    with (
        pytest.raises(ConfigError, match="No such file"),
        QueuedReceiver("log", closed(), pytest.fail),
    ):
        pytest.fail("it is not open")
