"""The page that drives, in a time of its own: what it asks for and when it counts as gone."""

from __future__ import annotations

import asyncio
from collections.abc import Coroutine, Iterator
from contextlib import ExitStack, closing
from typing import Any, TypeVar

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from language.template_texts import commands_of
from starlette.exceptions import HTTPException

import voz
from voz.apps.servers.command_bridge import CommandBridge
from voz.apps.web import page_registry
from voz.apps.web.driver_lock import DRIVER_TIMEOUT, PAGE_GONE
from voz.apps.web.live_page import LivePage
from voz.apps.web.page_messages import EventHistory
from voz.apps.web.page_registry import COUNTS_AS_GONE, NOT_DRIVING, OpenPage, PageRegistry
from voz.control.messages import End
from voz.events import Event, Notice, Utterance
from voz.inbox import Inbox
from voz.run.live import PAGE
from voz.run.session import Session
from voz.run.spec import RunSpec

COMMANDS = commands_of("start speech\nstop speech\nstop\ngo forward\ngo back\n")

BEAT = 0.1
"""Between two beats, s."""

Answer = TypeVar("Answer")


class Run:
    """A robot, its page and two who have opened it; nothing happens but what a test lets happen."""

    def __init__(self, browser_listens: bool = False) -> None:
        self.now = 100.0  # the time of the run, s
        self.events: list[Event] = []
        self.controller = voz.Controller([self.events.append], listening=True)
        self._inbox = Inbox({"stop", "stop speech"})
        clock: Any = self
        address: Any = None  # it is not served
        self.session = Session(RunSpec(controller=self.controller, inbox=self._inbox))
        self.session.clock = clock
        page = LivePage(
            self.session, address, browser_listens=browser_listens, now=lambda: self.now
        )
        self.session.watch(PAGE, lambda: page.trouble(self.controller.moving), *page.sources)
        self.lock = page.driver_lock
        self.registry = PageRegistry(
            CommandBridge(self._inbox, lambda: self.now, lambda: COMMANDS),
            EventHistory(lambda _: None),
            self.lock,
            warn=lambda _: None,
            microphone=None,
            set_rehearsal=lambda _: None,
            now=lambda: self.now,
        )
        self.controller.receivers.append(self.registry.publish)
        self._loop = asyncio.new_event_loop()
        self._opened = [ExitStack(), ExitStack()]
        self.pages = [self._enter(number) for number in (0, 1)]  # who has opened the page

    def _enter(self, number: int) -> OpenPage:
        return self._opened[number].enter_context(self.registry.registered("phone"))

    def reopen(self, number: int) -> None:
        """One page is closed and opened again, as by a reload."""
        self._opened[number].close()
        self.pages[number] = self._enter(number)

    def close(self) -> None:
        """End what still waits for the control loop."""
        for task in asyncio.all_tasks(self._loop):
            task.cancel()
        self.work()
        self._loop.close()

    def beat(self, beats: int = 1) -> None:
        """Let time pass, and what has come take effect."""
        for _ in range(beats):
            self.now = round(self.now + BEAT, 3)
            self._take()
            self.session.on_beat(self.now)
            self.registry.broadcast_state({})
            self.work()

    def _take(self) -> None:
        while not self._inbox.is_empty and (message := self._inbox.take(0.001)) is not None:
            assert not isinstance(message, End)
            self.controller.take(message, self.now)

    def work(self) -> None:
        self._loop.run_until_complete(asyncio.sleep(0))

    def _start(self, work: Coroutine[Any, Any, Answer]) -> asyncio.Task[Answer]:
        task = self._loop.create_task(work)
        for _ in range(3):  # until it waits for the control loop
            self.work()
        return task

    def post(self, secret: str | None, text: str = "go forward") -> asyncio.Task[Utterance]:
        """Send a command by POST; its answer may need a beat."""
        return self._start(self.registry.command(text, secret))

    def hear(self, source: str, text: str = "go forward") -> None:
        """Somebody says or types a command."""
        self.controller.hear(Utterance(self.now, text, 1.0, True, self.now, self.now, source))

    def drives(self) -> None:
        """The first page drives a robot that moves."""
        assert self.registry.start_driving(self.pages[0], False)
        answer = self.post(self.pages[0].secret)
        self.beat()
        assert answer.result().obeyed
        assert self.controller.moving

    @property
    def warnings(self) -> list[str]:
        return [event.text for event in self.events if isinstance(event, Notice)]


def refusal(answer: asyncio.Task[Utterance]) -> tuple[int, str]:
    """Why a command was refused at once: the status and the words."""
    assert answer.done()
    error = answer.exception()
    assert isinstance(error, HTTPException)
    return error.status_code, str(error.detail)


@pytest.fixture(autouse=True)
def _no_pause(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(page_registry, "NOTICE_INTERVAL", 0.0)


@pytest.fixture
def run() -> Iterator[Run]:
    with closing(Run()) as run:
        yield run


def test_a_page_that_counts_as_gone_is_refused_at_once_and_drives_on_when_it_answers(
    run: Run,
) -> None:
    run.drives()
    run.beat(4)
    assert run.warnings == [f"{PAGE_GONE}: the robot stops"]
    for _ in range(30):  # a tap comes by POST, while the page's other connection hangs
        assert refusal(run.post(run.pages[0].secret)) in ((409, COUNTS_AS_GONE), (409, NOT_DRIVING))
        run.beat()
        assert not run.controller.moving
    assert run.lock.driver is None
    run.registry.start_driving(run.pages[0], False)
    again = run.post(run.pages[0].secret)
    run.beat(2)
    assert again.result().obeyed
    assert run.controller.moving


def test_a_program_that_never_says_that_it_is_there_moves_the_robot_for_less_than_half_a_second(
    run: Run,
) -> None:
    run.registry.start_driving(run.pages[0], False)
    moving = 0
    for _ in range(20):
        run.post(run.pages[0].secret)
        run.beat()
        moving += run.controller.moving
    assert moving * BEAT <= DRIVER_TIMEOUT + BEAT


@pytest.mark.parametrize("pause", [3, 20])
def test_who_commands_at_once_after_a_loss_is_obeyed_once_the_control_loop_knows(
    pause: int, run: Run
) -> None:
    run.drives()
    run.beat(pause)
    run.registry.start_driving(run.pages[0], False)  # as voz.Client before each command
    answer = run.post(run.pages[0].secret)
    assert not answer.done()
    run.beat(2)
    assert answer.result().obeyed
    assert run.controller.moving


def test_a_control_loop_that_does_not_notice_is_no_leave_to_drive(run: Run) -> None:
    run.drives()
    run.beat(5)
    run.registry.keep_alive(run.pages[0])
    answer = run.post(run.pages[0].secret)
    for _ in range(page_registry.MAX_NOTICE_LOOKS + 1):
        run.work()
    assert "the control loop does not answer" in str(answer.exception())


@pytest.mark.parametrize("source", ["page", "browser"])
def test_what_comes_from_a_page_that_is_gone_all_the_same_moves_nothing(source: str) -> None:
    with closing(Run(browser_listens=True)) as run:
        run.drives()
        run.beat(5)
        run.hear(source)
        assert not run.controller.moving
        run.hear("microphone")
        run.beat(3)
        assert run.controller.moving  # somebody is in the room


def test_without_a_page_a_program_is_obeyed_after_the_page_was_closed(run: Run) -> None:
    run.drives()
    run.reopen(0)
    run.beat(2)
    assert not run.controller.moving
    answer = run.post(None)
    run.beat()
    assert answer.result().obeyed
    assert run.controller.moving


STEPS = st.lists(
    st.tuples(
        st.sampled_from(
            ["seen", "drive", "over", "leave", "reopen", "post", "post", "past", "nobody", "typed"]
        ),
        st.sampled_from([0, 1]),
        st.integers(0, 4),
    ),
    max_size=25,
)


@given(STEPS)
@settings(max_examples=150, deadline=None)
def test_whatever_happens_in_whatever_order_no_page_that_is_gone_moves_the_robot(
    steps: list[tuple[str, int, int]],
) -> None:
    with closing(Run()) as run:
        run.registry.start_driving(run.pages[0], False)
        for what, number, beats in steps:
            page = run.pages[number]
            there = run.registry.is_answering(page)
            if what == "seen":
                run.registry.keep_alive(page)
            elif what in ("drive", "over"):
                run.registry.start_driving(page, what == "over")
            elif what == "leave":
                run.registry.stop_driving(page)
            elif what == "reopen":
                run.reopen(number)
            elif what == "post":
                answer = run.post(page.secret)
                assert there or refusal(answer)[0] == 409
            elif what == "nobody":
                run.post(None)
            elif what == "typed":
                run.hear("text")
            elif run.lock.driver is not None:  # past the server: the second defense
                run.hear("page")
            for _ in range(beats):
                run.beat()
                obeyed = [e for e in run.events if isinstance(e, Utterance) and e.obeyed]
                if run.controller.moving and obeyed[-1].source == "page":
                    assert run.lock.is_answering(run.lock.driver or 0, run.now)
