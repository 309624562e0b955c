"""The open pages: which of them is driving, and what all of them are sent."""

from __future__ import annotations

import asyncio
import secrets
import time
from collections import deque
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from http import HTTPStatus
from itertools import count

from starlette.exceptions import HTTPException

from voz.apps.servers.command_bridge import COMMAND_TIMEOUT, CommandBridge
from voz.apps.servers.connections import RateLimit
from voz.apps.web.access_control import secrets_equal
from voz.apps.web.driver_lock import DriverLock
from voz.apps.web.page_messages import (
    PAGE_SOURCE,
    PROGRAM_SOURCE,
    EventHistory,
    Record,
    encode_record,
)
from voz.apps.web.page_sound import BrowserMicrophone
from voz.control.table import STOP
from voz.errors import RobotError
from voz.events import Event, Notice, Utterance

STOPPED_BY_PAGE = "stopped from the operator page"

MAX_PAGES = 100

MAX_PENDING_RECORDS = 300
"""Records that wait for a slow page; with more its connection is closed."""

COMMAND_RATE, COMMAND_BURST = 5.0, 20.0
"""Commands per second, and at once: of the driving page, or of all programs while none drives."""

NOTICE_INTERVAL = 0.01
"""Between two looks whether the control loop knows of the page that drives, s."""

MAX_NOTICE_LOOKS = round(COMMAND_TIMEOUT / NOTICE_INTERVAL)

NOT_DRIVING = "another page drives, or none: press Drive first"

COUNTS_AS_GONE = "this page counts as gone, for it does not answer: give the command again"

MAX_RECENT_EVENTS = 6000
"""Events kept for the diagnostics: ten minutes."""


class OpenPage:
    """What is to be sent to one page: every record, and of the states only the newest."""

    def __init__(self, number: int, secret: str, name: str) -> None:
        self.number = number  # of the page, one for each that was ever open
        self.secret = secret  # authorizes whoever knows it to drive as this page
        self.name = name  # what people call it
        self.stops = 0  # how often it has asked for a stop, by its own count
        self.too_slow = False  # whether more records waited than may
        self._records: deque[str] = deque()
        self._state: str | None = None
        self._available = asyncio.Event()

    def put(self, record: str) -> None:
        """Send a record after those before it."""
        if len(self._records) >= MAX_PENDING_RECORDS:
            self.too_slow = True
        else:
            self._records.append(record)
        self._available.set()

    def put_state(self, state: str) -> None:
        """Send a state in place of one that was not sent yet."""
        self._state = state
        self._available.set()

    async def take(self) -> list[str]:
        """Wait for what is to be sent, and return it."""
        await self._available.wait()
        self._available.clear()
        records = [*self._records, *([self._state] if self._state else [])]
        self._records.clear()
        self._state = None
        return records


class PageRegistry:
    """The open pages. Event-loop thread only.

    Attributes:
        microphone: gets the sound of the driving page; None if the robot's own is used.
    """

    def __init__(
        self,
        bridge: CommandBridge,
        history: EventHistory,
        driver_lock: DriverLock,
        *,
        warn: Callable[[str], None],
        microphone: BrowserMicrophone | None,
        set_rehearsal: Callable[[bool], None],
        now: Callable[[], float] = time.monotonic,
    ) -> None:
        self.microphone = microphone
        self._bridge = bridge
        self._history = history
        self._driver_lock = driver_lock
        self._warn = warn
        self._set_rehearsal = set_rehearsal
        self._now = now
        self._recent: deque[str] = deque(maxlen=MAX_RECENT_EVENTS)
        self._pages: dict[int, OpenPage] = {}
        self._numbers = count(1)
        self._command_limit = RateLimit(COMMAND_RATE, COMMAND_BURST)
        self._reported_stops: set[type[Event]] = set()  # since the last state

    @property
    def is_full(self) -> bool:
        """Whether no more pages can be served."""
        return len(self._pages) >= MAX_PAGES

    @property
    def status(self) -> Record:
        """How many pages are open, and which one is driving."""
        driver = self._pages.get(self._driver_lock.driver or 0)
        return {
            "pages": len(self._pages),
            "driver": driver.number if driver else None,
            "driver_name": driver.name if driver else None,
        }

    @property
    def question(self) -> Record | None:
        """What the robot has asked, what may be said to that, and which of it are commands."""
        if not (answers := self._history.answers):
            return None
        sentences = [self._bridge.sentence(answer) for answer in answers]
        given = [sentence for sentence in sentences if sentence]
        return {"text": self._history.question, "answers": answers, "commands": given}

    @property
    def remembered(self) -> list[Record]:
        """The last utterances, replies and warnings."""
        return self._history.remembered

    def has_said(self, text: str) -> bool:
        """Whether the robot has said something recently."""
        return any(r["type"] == "reply" and r["text"] == text for r in self.remembered)

    @property
    def recent(self) -> list[str]:
        """All events of the last minutes, as JSON."""
        return list(self._recent)

    def publish(self, event: Event) -> None:
        """Send an event to all pages.

        Of the stops that pages ask for, one between two states is sent: many at once would make
        the driving page too slow to follow.
        """
        self._bridge.receive(event)
        if _is_stop_by_page(event):
            if type(event) in self._reported_stops:
                return
            self._reported_stops.add(type(event))
        self._recent.append(self.broadcast(self._history.add(event)))

    def broadcast(self, record: Record) -> str:
        """Send a record to all pages; returns it as JSON."""
        text = encode_record(record)
        for page in self._pages.values():
            page.put(text)
        return text

    def broadcast_state(self, state: Record) -> None:
        """Send the current state to all pages, and release a driver that has fallen silent."""
        self._reported_stops.clear()
        self._driver_lock.release_if_silent(self._now())
        text = encode_record({"type": "state", **state, **self.status})
        for page in self._pages.values():
            page.put_state(text)

    @contextmanager
    def registered(self, device: str) -> Iterator[OpenPage]:
        """Register a page for a `with` block; if it is driving then, nobody is afterwards.

        `device` is what people call the device that it is on.
        """
        number = next(self._numbers)
        page = OpenPage(number, secrets.token_urlsafe(16), self._unused_name(device, number))
        self._pages[page.number] = page
        try:
            yield page
        finally:
            del self._pages[page.number]
            self._driver_lock.release(page.number)

    def _unused_name(self, device: str, number: int) -> str:
        """A name such as "iPhone, since 10:42" that no other open page has."""
        name = f"{device}, since {time.strftime('%H:%M')}"
        taken = any(page.name == name for page in self._pages.values())
        return f"{name} (page {number})" if taken else name

    def keep_alive(self, page: OpenPage) -> None:
        """Note that a page has answered."""
        self._driver_lock.keep_alive(page.number, self._now())

    def start_driving(self, page: OpenPage, take_over: bool) -> bool:
        """Let a page drive; returns whether it does. If another did just now, the robot stops."""
        before, just_released = self._driver_lock.driver, self._driver_lock.just_released
        replaced = self._pages.get(before or 0)
        if before == page.number:
            self.keep_alive(page)
            return True
        if not self._driver_lock.acquire(page.number, take_over, self._now()):
            return False
        if self.microphone:
            self.microphone.end_stream(complete=False)
        if before is not None or just_released:
            self._bridge.halt(STOPPED_BY_PAGE)
        if replaced:
            self._warn(f"{page.name}, drives now, no longer {replaced.name}: the robot stops")
        return True

    def stop_driving(self, page: OpenPage) -> None:
        """Let a page drive no more; the robot stops."""
        if self._driver_lock.release(page.number):
            self._bridge.halt(STOPPED_BY_PAGE)

    def set_rehearsal(self, page: OpenPage, on: bool) -> None:
        """Begin or end a rehearsal, if the page is driving; the robot stops."""
        if self.is_driving(page):
            self._set_rehearsal(on)
            self._bridge.halt(STOPPED_BY_PAGE)
            begun = "rehearsal: commands are recognized, and only stop is obeyed"
            self._warn(begun if on else "the rehearsal is over: commands are obeyed")

    async def command(self, text: str, secret: str | None, stops: int | None = None) -> Utterance:
        """Obey a sentence as if it were typed; what stops the robot is never refused.

        Args:
            text: the sentence.
            secret: of the page that sends it; None from a program, allowed while no page drives.
                What such a program begins, which nobody watches, has an end.
            stops: how often the page had asked for a stop before; None if it does not say.

        Returns:
            The utterance, with what became of it.

        Raises:
            HTTPException: another page is driving, the page counts as gone, commands come faster
                than `COMMAND_RATE`, or the page has asked for a stop since it sent this one.
            RobotError: the control loop did not answer.
        """
        page = self.page_with_secret(secret) if secret else None
        if not self._bridge.stops(self._bridge.read(text)):
            await self._check_allowed(page, secret, stops)
        return await self._bridge.command(text, PAGE_SOURCE if page else PROGRAM_SOURCE)

    async def _check_allowed(
        self, page: OpenPage | None, secret: str | None, stops: int | None
    ) -> None:
        """Raise HTTPException for a command that may not move the robot; see `command`."""
        if page:
            await self._wait_until_noticed(page)
        elif secret or self._driver_lock.driver is not None:
            raise HTTPException(HTTPStatus.CONFLICT, NOT_DRIVING)
        if not self._command_limit.allows(self._now()):
            raise HTTPException(HTTPStatus.TOO_MANY_REQUESTS, "too many commands")
        if page and stops is not None and stops < page.stops:
            raise HTTPException(HTTPStatus.CONFLICT, "a stop came after it: give it again")

    async def _wait_until_noticed(self, page: OpenPage) -> None:
        """Wait until the control loop knows that a page drives again, for it stops the robot then.

        Without this, a program that drives and commands at once is stopped just after it. Raises
        HTTPException at once if the page does not drive, or counts as gone.
        """
        for _ in range(MAX_NOTICE_LOOKS):
            self._check_answering(page)
            if not self._driver_lock.reported_gone:
                return
            await asyncio.sleep(NOTICE_INTERVAL)
        raise RobotError("the control loop does not answer")

    def _check_answering(self, page: OpenPage) -> None:
        if not self.is_driving(page):
            raise HTTPException(HTTPStatus.CONFLICT, NOT_DRIVING)
        if not self.is_answering(page):
            raise HTTPException(HTTPStatus.CONFLICT, COUNTS_AS_GONE)

    async def stop(self, page: OpenPage | None = None, number: int = 0) -> float:
        """Stop the robot; returns when zero velocity was sent, s.

        `number` is how often the page has asked by now. Raises RobotError without an answer.
        """
        if page:
            page.stops = max(page.stops, number)
        return await self._bridge.stop(PAGE_SOURCE, STOPPED_BY_PAGE)

    def page_with_secret(self, secret: str) -> OpenPage | None:
        """Find the page that a secret belongs to."""
        return next((p for p in self._pages.values() if secrets_equal(secret, p.secret)), None)

    def check_driving(self, secret: str) -> None:
        """Raise HTTPException unless the page with this secret is driving."""
        page = self.page_with_secret(secret)
        if page is None or not self.is_driving(page):
            why = "only the page that drives may do that: press Drive first"
            raise HTTPException(HTTPStatus.CONFLICT, why)

    def is_driving(self, page: OpenPage) -> bool:
        """Whether this page is driving."""
        return self._driver_lock.driver == page.number

    def is_answering(self, page: OpenPage) -> bool:
        """Whether this page is driving, and does not count as gone."""
        return self._driver_lock.is_answering(page.number, self._now())


def _is_stop_by_page(event: Event) -> bool:
    """Whether an event is one of the two that a stop asked for on a page causes."""
    if isinstance(event, Utterance):
        return event.source == PAGE_SOURCE and event.name == STOP
    return isinstance(event, Notice) and event.text == STOPPED_BY_PAGE
