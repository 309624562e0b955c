"""What waits for the loop: `stop` overtakes it, and a flood is cut."""

from __future__ import annotations

import signal
import threading
from collections.abc import Iterator
from contextlib import contextmanager

import pytest
from hypothesis import given
from hypothesis import strategies as st
from msgspec.structs import replace
from programs import PATIENCE

from voz.control.messages import End, Halt, Message, too_late
from voz.events import Notice, Partial, Utterance
from voz.inbox import MAX_QUEUED_MESSAGES, Inbox


def said(text: str, accepted: bool = True) -> Utterance:
    return Utterance(0, text, 0.9, accepted, 0, 0, "microphone")


ORDINARY = [said("go back"), said("stop", accepted=False), Partial(0, "go back", 1), Notice(0, "")]
STOPPING = [said("stop"), said("stop speech"), Partial(0, "stop", 1), Halt(), End()]


def in_time(message: Message) -> Message:
    """A message as if no stop had overtaken it."""
    return replace(message, ignored=None) if isinstance(message, Utterance) else message


def all_of(inbox: Inbox) -> list[Message]:
    taken = []
    while (one := inbox.take(0)) is not None:
        taken.append(one)
    return taken


@pytest.mark.parametrize("message", STOPPING)
def test_what_stops_overtakes_what_waits_and_that_is_known_of_it(message: Message) -> None:
    inbox = Inbox({"stop", "stop speech"})
    for one in (said("go back"), message, said("go forward")):
        inbox.put(one)
    assert all_of(inbox) == [
        message,
        too_late(said("go back")),
        said("go forward"),
    ]


@given(st.lists(st.sampled_from([*ORDINARY, *STOPPING])))
def test_each_message_is_taken_once_and_stops_first(messages: list[Message]) -> None:
    inbox = Inbox({"stop", "stop speech"})
    for message in messages:
        inbox.put(message)
    taken = [in_time(one) for one in all_of(inbox)]
    first = [message for message in messages if message in STOPPING]
    rest = [message for message in messages if message not in STOPPING]
    kept = [m for n, m in enumerate(first) if n < MAX_QUEUED_MESSAGES or m == End()]
    assert taken == kept + rest[:MAX_QUEUED_MESSAGES]
    assert inbox.dropped == len(messages) - len(taken)


@given(st.lists(st.sampled_from([*ORDINARY, *STOPPING]), min_size=1, max_size=300))
def test_what_was_said_before_a_stop_is_known_to_be_even_if_that_was_dropped(
    messages: list[Message],
) -> None:
    inbox = Inbox({"stop", "stop speech"})
    for message in messages:
        inbox.put(message)
    places = [n for n, message in enumerate(messages) if message in STOPPING]
    usual = [n for n, message in enumerate(messages) if message not in STOPPING][
        :MAX_QUEUED_MESSAGES
    ]
    taken = [one for one in all_of(inbox) if one not in STOPPING]
    overtaken = [n < max(places, default=-1) for n in usual]
    expected = [
        too_late(messages[n]) if late else messages[n]
        for n, late in zip(usual, overtaken, strict=True)
    ]
    assert taken == expected


def test_64_messages_may_wait() -> None:
    inbox = Inbox({"stop"})
    for _ in range(66):
        inbox.put(Notice(0, ""))
    assert inbox.dropped == 2
    assert len(all_of(inbox)) == 64


def test_nothing_is_taken_where_nothing_is() -> None:
    assert Inbox({"stop", "stop speech"}).take(0.01) is None


@pytest.mark.parametrize("message", [Notice(0, ""), Halt()])
def test_it_is_empty_until_something_is_put_there(message: Message) -> None:
    inbox = Inbox({"stop"})
    assert inbox.is_empty
    inbox.put(message)
    assert not inbox.is_empty
    inbox.take(0)
    assert inbox.is_empty


@pytest.mark.parametrize("timeout", [0.5, 1000.0])
def test_who_waits_sleeps_until_something_comes(
    timeout: float, monkeypatch: pytest.MonkeyPatch
) -> None:
    inbox = Inbox({"stop"})
    inbox.put(Halt())
    inbox.take(0)  # what came before wakes nobody any more
    taken: list[Message] = []
    looks = 0

    def now() -> float:
        nonlocal looks
        looks += 1
        return 0.0

    def wait() -> None:
        while (message := inbox.take(timeout)) is None:
            assert timeout < 1000
        taken.append(message)

    monkeypatch.setattr("voz.inbox.time.monotonic", now)
    thread = threading.Thread(target=wait, daemon=True)
    thread.start()
    thread.join(0.05)
    inbox.put(Notice(0, ""))
    thread.join(PATIENCE)
    assert taken == [Notice(0, "")]
    assert looks < 100


def test_a_wait_of_a_microsecond_ends_whatever_arrives_meanwhile() -> None:
    inbox = Inbox({"stop"})

    def talk() -> None:
        for _ in range(2_000):
            inbox.put(said("go back"))

    def listen() -> None:
        for _ in range(10_000):
            inbox.take(1e-6)

    threads = [threading.Thread(target=work, daemon=True) for work in (talk, listen)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join(60)
    assert not any(thread.is_alive() for thread in threads)


def test_a_flood_from_many_threads_is_cut_and_counted() -> None:
    inbox = Inbox({"stop", "stop speech"})

    def flood() -> None:
        for number in range(2000):
            inbox.put(said("stop") if number % 200 == 0 else said("go back", accepted=False))

    threads = [threading.Thread(target=flood) for _ in range(4)]
    for thread in threads:
        thread.start()
    taken: list[Message] = []
    while any(thread.is_alive() for thread in threads):
        if (one := inbox.take(0.01)) is not None:
            taken.append(one)
    taken += all_of(inbox)
    assert any(one == said("stop") for one in taken)
    assert len(taken) + inbox.dropped == 8000


@contextmanager
def alarms(handler: object) -> Iterator[None]:
    """Signals that come every millisecond and a half."""
    before = signal.signal(signal.SIGALRM, handler)  # type: ignore[arg-type]
    signal.setitimer(signal.ITIMER_REAL, 0.0015, 0.0015)
    try:
        yield
    finally:
        signal.setitimer(signal.ITIMER_REAL, 0)
        signal.signal(signal.SIGALRM, before)


def test_signals_may_put_messages_in_the_midst_of_any_call() -> None:
    inbox = Inbox({"stop", "stop speech"})
    put = 0

    def handler(*_: object) -> None:
        nonlocal put
        put += 1
        inbox.put(Halt())

    taken = 0
    with alarms(handler):
        while put < 300:
            inbox.put(Notice(0, ""))
            taken += inbox.take(0.002) is not None
    halts = [one for one in all_of(inbox) if one == Halt()]
    assert len(halts) < 300  # most were taken at once
    assert taken >= 300


def flood_lines(dropped: dict[float, int]) -> list[tuple[float, str]]:
    """What is told of a flood: by the time of each look (s), what was dropped so far."""
    inbox, told = Inbox(set()), []
    for t, inbox.dropped in dropped.items():
        told.append((t, inbox.flood_report(t)))
    return [(t, text) for t, text in told if text]


def test_a_flood_is_one_line_when_it_is_over() -> None:
    looks = {20 + t / 10: min(max(t - 3, 0), 4) * 100 for t in range(100)}
    assert flood_lines(looks) == [(20.8, "400 messages came too fast and were dropped")]


@pytest.mark.parametrize("first", [0, 1])
def test_a_flood_without_an_end_is_a_line_now_and_then(first: int) -> None:
    lines = flood_lines({t / 10: t * 100 for t in range(first, 160)})
    assert [t for t, _ in lines] == [5.0, 10.0, 15.0]
    assert lines[1][1] == "5000 messages came too fast and were dropped"
