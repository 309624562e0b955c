"""What waits for the loop: `stop` overtakes it, and a flood is cut."""

from __future__ import annotations

import signal
import threading
from collections.abc import Iterator
from contextlib import contextmanager

import pytest
from hypothesis import given
from hypothesis import strategies as st

from voz.events import Notice, Partial, Utterance
from voz.inbox import MAX_QUEUED_MESSAGES, End, Halt, Inbox, Message, TakenMessage


def said(text: str, accepted: bool = True) -> Utterance:
    return Utterance(0, text, 0.9, accepted, 0, 0, "microphone")


ORDINARY = [said("go back"), said("stop", accepted=False), Partial(0, "go back", 1), Notice(0, "")]
STOPPING = [said("stop"), said("stop speech"), Partial(0, "stop", 1), Halt(), End()]


def all_of(inbox: Inbox) -> list[TakenMessage]:
    taken = []
    while one := inbox.take(0):
        taken.append(one)
    return taken


@pytest.mark.parametrize("message", STOPPING)
def test_what_stops_overtakes_what_waits_and_that_is_known_of_it(message: Message) -> None:
    inbox = Inbox({"stop", "stop speech"})
    for one in (said("go back"), message, said("go forward")):
        inbox.put(one)
    assert all_of(inbox) == [
        TakenMessage(message, False),
        TakenMessage(said("go back"), True),
        TakenMessage(said("go forward"), False),
    ]


@given(st.lists(st.sampled_from([*ORDINARY, *STOPPING])))
def test_each_message_is_taken_once_and_stops_first(messages: list[Message]) -> None:
    inbox = Inbox({"stop", "stop speech"})
    for message in messages:
        inbox.put(message)
    taken = [one.message for one in all_of(inbox)]
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
    taken = [one for one in all_of(inbox) if one.message not in STOPPING]
    assert [one.overtaken for one in taken] == [n < max(places, default=-1) for n in usual]


def test_nothing_is_taken_where_nothing_is() -> None:
    assert Inbox({"stop", "stop speech"}).take(0.01) is None


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
    taken: list[TakenMessage] = []
    while any(thread.is_alive() for thread in threads):
        if one := inbox.take(0.01):
            taken.append(one)
    taken += all_of(inbox)
    assert any(one.message == said("stop") for one in taken)
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
            taken += isinstance(inbox.take(0.002), TakenMessage)
    halts = [one for one in all_of(inbox) if one.message == Halt()]
    assert len(halts) < 300  # most were taken at once
    assert taken >= 300
