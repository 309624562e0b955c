"""Where pages and the run meet: who is there, who drives, what all are told. On one thread."""

from __future__ import annotations

import secrets
import time
from collections import deque
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from itertools import count

from voz.apps.web.asking import BY_PAGE, PAGE, Asking
from voz.apps.web.board import Board, Record, encoded
from voz.apps.web.browser_microphone import BrowserMicrophone
from voz.apps.web.doors import same_secret
from voz.apps.web.limits import Limit
from voz.apps.web.watcher import Watcher
from voz.apps.web.wheel import Wheel
from voz.control.table import STOP
from voz.events import Event, Utterance, Warning

MOST_PAGES = 100
"""At a time; more are turned away."""

COMMANDS_EACH_SECOND, COMMANDS_AT_ONCE = 5.0, 20.0
"""Of the page that drives, or of all programs while none does."""

MOST_RECENT = 6000
"""Events that are kept for who asks what went wrong: ten minutes."""


class TakenError(Exception):
    """Another page drives."""


class TooManyError(Exception):
    """Whoever drives gives more commands than anybody can mean."""


class OvertakenError(Exception):
    """The page asked for a stop after it, which came before it."""


class Desk:
    """Knows the pages; used on the server's thread alone.

    Attributes:
        microphone: of the page that drives; None if the robot's own is listened to.
    """

    def __init__(
        self,
        asking: Asking,
        board: Board,
        wheel: Wheel,
        warn: Callable[[str], None],
        microphone: BrowserMicrophone | None,
        rehearse: Callable[[bool], None],
    ) -> None:
        """Begin with no page.

        Args:
            asking: puts commands into the run.
            board: what was before.
            wheel: who drives.
            warn: takes what all should know.
            microphone: gets the sound of the page that drives.
            rehearse: lets commands be understood and not be obeyed, or ends that.
        """
        self.microphone = microphone
        self._asking = asking
        self._board = board
        self._wheel = wheel
        self._warn = warn
        self._rehearse = rehearse
        self._recent: deque[str] = deque(maxlen=MOST_RECENT)
        self._watchers: dict[int, Watcher] = {}
        self._numbers = count(1)
        self._commands = Limit(COMMANDS_EACH_SECOND, COMMANDS_AT_ONCE)
        self._reported_stops: set[type[Event]] = set()  # since the last state

    @property
    def full(self) -> bool:
        """Whether no more pages can be served."""
        return len(self._watchers) >= MOST_PAGES

    @property
    def pages(self) -> Record:
        """Who is there."""
        driver = self._watchers.get(self._wheel.driver or 0)
        return {
            "pages": len(self._watchers),
            "driver": driver.number if driver else None,
            "driver_name": driver.name if driver else None,
        }

    @property
    def remembered(self) -> list[Record]:
        """The last that was heard, said and warned of."""
        return self._board.remembered

    def has_said(self, text: str) -> bool:
        """Whether the robot said something just now."""
        return any(r["type"] == "reply" and r["text"] == text for r in self.remembered)

    @property
    def recent(self) -> list[str]:
        """All events of the last minutes, as JSON."""
        return list(self._recent)

    def take(self, event: Event) -> None:
        """Tell all pages of an event.

        Of the stops that pages ask for, one between two states is reported: many at once would
        make the page that drives too slow to follow.
        """
        self._asking.take(event)
        if _is_stop_by_page(event):
            if type(event) in self._reported_stops:
                return
            self._reported_stops.add(type(event))
        self._recent.append(self.tell(self._board.take(event)))

    def tell(self, record: Record) -> str:
        """Tell all pages something; gives it as JSON."""
        told = encoded(record)
        for watcher in self._watchers.values():
            watcher.put(told)
        return told

    def show(self, state: Record) -> None:
        """Tell all pages how things are, and look whether the one that drives is still there."""
        self._reported_stops.clear()
        self._wheel.vacated(time.monotonic())
        record = encoded({"type": "state", **state, **self.pages})
        for watcher in self._watchers.values():
            watcher.put_state(record)

    @contextmanager
    def watching(self, address: str) -> Iterator[Watcher]:
        """Let a page watch for the length of a `with` block; if it drives, nobody does then."""
        watcher = Watcher(next(self._numbers), secrets.token_urlsafe(16), address)
        self._watchers[watcher.number] = watcher
        try:
            yield watcher
        finally:
            del self._watchers[watcher.number]
            self._wheel.leave(watcher.number)

    def seen(self, watcher: Watcher) -> None:
        """Note a sign of a page."""
        self._wheel.seen(watcher.number, time.monotonic())

    def drive(self, watcher: Watcher, over: bool) -> bool:
        """Let a page drive, and tell whether it does; if another did just now, the robot stops.

        Args:
            watcher: the page.
            over: whether it takes over from another that drives.
        """
        before, just_left = self._wheel.driver, self._wheel.just_left
        if before == watcher.number:
            return True
        if not self._wheel.take(watcher.number, over, time.monotonic()):
            return False
        if self.microphone:
            self.microphone.end(whole=False)
        if before is not None or just_left:
            self._asking.halt()
        if before is not None:
            self._warn(f"{watcher.name} drives now, no longer page {before}: the robot stops")
        return True

    def leave(self, watcher: Watcher) -> None:
        """Let a page drive no more; the robot stops."""
        if self._wheel.leave(watcher.number):
            self._asking.halt()

    def rehearse(self, watcher: Watcher, on: bool) -> None:
        """Begin or end a rehearsal, if the page drives; the robot stops."""
        if self.drives(watcher):
            self._rehearse(on)
            self._asking.halt()
            told = "a rehearsal: commands are understood, and none but stop is obeyed"
            self._warn(told if on else "the rehearsal is over: commands are obeyed")

    async def command(self, text: str, secret: str | None, stops: int | None = None) -> Utterance:
        """Obey a sentence as if it were typed.

        Args:
            text: the sentence.
            secret: of the page that gives it; None of a program, which may while no page drives.
            stops: how often the page had asked for a stop before; None if it does not say.

        Returns:
            What became of it.

        Raises:
            TakenError: another page drives.
            TooManyError: there were too many before it.
            OvertakenError: the page has asked for a stop since.
            NotDone: the control loop did not answer.
        """
        page = self.page_of(secret) if secret else None
        if self._wheel.driver != (page.number if page else None) or (secret and not page):
            raise TakenError
        if not self._commands.allows(time.monotonic()):
            raise TooManyError
        if page and stops is not None and stops < page.stops:
            raise OvertakenError
        return await self._asking.command(text)

    async def stop(self, page: Watcher | None = None, number: int = 0) -> float:
        """Stop the robot, whoever asks; gives when it was, or raises NotDone.

        Args:
            page: which asks, if one does.
            number: how often it has asked by now.
        """
        if page:
            page.stops = max(page.stops, number)
        return await self._asking.stop()

    def page_of(self, secret: str) -> Watcher | None:
        """Find the page that a secret is of."""
        return next((w for w in self._watchers.values() if same_secret(secret, w.secret)), None)

    def driven_by(self, secret: str) -> bool:
        """Whether it is the page with this secret that drives."""
        page = self.page_of(secret)
        return page is not None and self.drives(page)

    def drives(self, watcher: Watcher) -> bool:
        """Whether it is this page that drives."""
        return self._wheel.driver == watcher.number


def _is_stop_by_page(event: Event) -> bool:
    """Whether it is one of the two events of a stop that was asked for on a page."""
    if isinstance(event, Utterance):
        return event.source == PAGE and event.name == STOP
    return isinstance(event, Warning) and event.text == BY_PAGE
