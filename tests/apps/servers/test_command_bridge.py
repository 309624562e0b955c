"""Which of the events that come back answers which command."""

from __future__ import annotations

import asyncio
import threading
from collections.abc import Coroutine
from typing import Any, TypeVar

import pytest

from voz.apps.servers import command_bridge
from voz.apps.servers.command_bridge import MAX_QUEUED_EVENTS, CommandBridge, EventQueue
from voz.control.messages import Halt
from voz.errors import RobotError
from voz.events import Event, Notice, Reply, Twist, Utterance
from voz.inbox import Inbox
from voz.language.sentences.command_set import plain_commands

Answer = TypeVar("Answer")


class Run:
    """A control loop that does what a test says, and a server that waits for it."""

    def __init__(self) -> None:
        self.now = 5.0
        self.inbox = Inbox({"stop"})
        commands = plain_commands(["stop", "go forward", "greet"])
        self.bridge = CommandBridge(self.inbox, lambda: self.now, lambda: commands)

    def taken(self) -> list[Any]:
        """What has come to the control loop."""
        found = []
        while not self.inbox.is_empty:
            found.append(self.inbox.take(0.001))
        return found

    def tell(self, *events: Event) -> None:
        """What the run reports."""
        for event in events:
            self.bridge.receive(event)

    async def begun(self, work: Coroutine[Any, Any, Answer]) -> asyncio.Task[Answer]:
        """Let a server begin with something, until it waits for the control loop."""
        task = asyncio.create_task(work)
        await asyncio.sleep(0)
        return task


@pytest.fixture
def run() -> Run:
    return Run()


def test_of_commands_that_come_at_once_each_gets_its_own_answer(run: Run) -> None:
    async def served() -> None:
        first = await run.begun(run.bridge.command("go forward", "page"))
        second = await run.begun(run.bridge.command("make coffee", "program"))
        one, other = run.taken()
        assert one.t < other.t
        assert (one.accepted, other.accepted, other.source) == (True, False, "program")
        stranger = Utterance(one.t, "go back", 1.0, True, 0, 1, "microphone")
        run.tell(stranger, other, one)
        assert (await first, await second) == (one, other)

    asyncio.run(served())


def test_a_stop_is_answered_by_the_zero_velocity_after_it(run: Run) -> None:
    async def served() -> None:
        stop = await run.begun(run.bridge.stop("page", "stopped there"))
        halt, said = sorted(run.taken(), key=lambda one: isinstance(one, Utterance))
        assert (halt, said.text) == (Halt("stopped there", said.t), "stop")
        run.tell(Twist(5.1, 0.0, 0.0), said, Twist(5.2, 0.1, 0.0))
        await asyncio.sleep(0)
        assert not stop.done()
        run.tell(Twist(5.3, 0.0, 0.0))
        assert await stop == 5.3

    asyncio.run(served())


def test_what_became_of_a_command_ends_with_the_next_velocity(run: Run) -> None:
    async def served() -> None:
        asked = await run.begun(run.bridge.carry_out("greet", "wyoming"))
        (said,) = run.taken()
        own = Reply(said.t, "hello"), Notice(said.t, "the lamp is broken")
        run.tell(said, own[0], Reply(4.0, "of another"), own[1], Twist(5.1, 0.0, 0.0))
        run.tell(Reply(said.t, "too late"))
        outcome = await asked
        assert outcome.utterance is said
        assert (outcome.replies, outcome.problems) == (("hello",), ("the lamp is broken",))

    asyncio.run(served())


def test_a_control_loop_that_does_not_answer_is_an_error(
    run: Run, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(command_bridge, "COMMAND_TIMEOUT", 0.01)
    with pytest.raises(RobotError, match="the control loop does not answer"):
        asyncio.run(run.bridge.command("go forward", "page"))
    (said,) = run.taken()
    run.tell(said)  # nobody waits any more


def test_only_what_the_commands_have_is_read_and_only_some_of_it_stops(run: Run) -> None:
    read = run.bridge.read
    assert run.bridge.stops(read("please stop"))
    assert not run.bridge.stops(read("go forward"))
    assert read("make coffee") is None
    assert (run.bridge.sentence("greet"), run.bridge.sentence("dance")) == ("greet", None)


def test_events_of_another_thread_come_in_order_and_the_oldest_go_first() -> None:
    events = EventQueue()
    for number in range(MAX_QUEUED_EVENTS + 5):
        events.receive(Reply(number, ""))

    async def taken() -> list[float]:
        times = []
        async for event in events.events():
            times.append(event.t)
            if len(times) == MAX_QUEUED_EVENTS:
                threading.Timer(0.01, events.receive, [Reply(-1.0, "")]).start()
            if event.t < 0:
                return times
        return times

    assert asyncio.run(taken()) == [*range(5, MAX_QUEUED_EVENTS + 5), -1.0]
