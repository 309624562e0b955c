"""The doors of a live run: a session in a stepped time, and who commands it by each."""

from __future__ import annotations

import asyncio
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager, nullcontext
from functools import partial
from typing import Any
from unittest import mock

from driving import robots_part
from promises.fake_time import SteppedInbox, Timeline, fake_time
from promises.page import Browser, FollowedMicrophone, Server
from promises.run import ROS2_SOURCE, Do, Given, Outcome, recognizer_for
from promises.sound import SilentMicrophone, SteppedMicrophone
from wyoming.asr import Transcript

from voz.apps.servers.connections import WYOMING_PLACES, ConnectionGuard
from voz.apps.web.live_page import LivePage
from voz.apps.wyoming.robot_service import CommandHandler, RobotService
from voz.control.messages import End, Halt, Rehearsal, Renewal
from voz.events import Event
from voz.hearing.microphone_thread import SoundSource
from voz.run.controller import controller_by
from voz.run.live import TakeText, drive_live
from voz.run.session import Session
from voz.run.spec import RunSpec

NONSENSE = "what is all this nonsense here"

FLOOD = 200
"""Texts at once."""

UNREACHABLE = "its cable is out"


def _take_nothing(_text: str, _source: str = "") -> None:
    """Obey nothing: no recognizer is there."""


class Live:
    """A live run with every source, of which a door uses one."""

    def __init__(self, given: Given, *, microphone: bool, browser_listens: bool) -> None:
        self.outcome = Outcome()  # what the robot gets
        self.timeline = Timeline()
        self.unreachable: str | None = None
        self.given = given
        self.inbox = SteppedInbox(self.timeline, given.table.halts)
        # The robot's own; None if the run has none.
        self.microphone = SteppedMicrophone(self.timeline) if microphone else None
        self._device = self.microphone or SilentMicrophone(self.timeline)
        self._followed: FollowedMicrophone | None = None
        self.server = Server()
        self.browser: Browser | None = None  # the page that drives; None if the run has none
        self.service: Service | None = None
        self.take_text = self._taking = _take_nothing
        self.lose_recognizer: Callable[[str], None] = lambda _: None
        self._browser_listens = browser_listens
        self._say: Callable[[Live, str], None] = lambda _live, _text: None

    def run(
        self,
        begin: Callable[[Live], None],
        say: Callable[[Live, str], None],
        script: Sequence[Do],
        seconds: float,
    ) -> None:
        """Do what a script says, after `begin` has opened the door; `say` gives a sentence."""
        self._say = say
        given, recognizer = self.given, recognizer_for(self.given.name, self.given.ask)
        self.timeline.at(0.05, lambda: begin(self))
        for do in script:
            self.timeline.at(do.at, lambda do=do: self._do(do))  # type: ignore[misc]
        self.timeline.at(seconds, self._end)
        self.timeline.each += [self._step]
        opened: Any = lambda: nullcontext(self._device)  # noqa: E731
        drive = partial(
            drive_live,
            recognizer=recognizer,
            sound=SoundSource(opened),
            other_recognizer=self._other_recognizer,
            page=self._page,
            service=self._service,
        )
        robots = robots_part(*given.receivers(self.outcome), wheels=lambda: self.unreachable)
        spec = RunSpec(
            controller=controller_by(given.settings, given.listening),
            settings=given.settings,
            inbox=self.inbox,
            outputs=[robots],
            parts=[drive],
        )
        with fake_time(self.timeline):
            try:
                Session(spec).run()
            except BaseException as error:
                self.outcome.error = error
            finally:
                recognizer.expect(())

    def _do(self, do: Do) -> None:
        done: dict[str, Callable[[], object]] = {
            "say": lambda: self._say(self, do.text),
            "rehearse": lambda: self.inbox.put(Rehearsal(on=True)),
            "rehearsed": lambda: self.inbox.put(Rehearsal(on=False)),
            "save the list": lambda: self._renew(under_way=True),
            "use the list": lambda: self._renew(under_way=False),
            "stall": lambda: self.timeline.stall(1.0),
            "lose the robot": lambda: setattr(self, "unreachable", UNREACHABLE),
            "find the robot": lambda: setattr(self, "unreachable", None),
            "lose the page": lambda: self.browser and self.browser.lose_network(),
            "find the page": lambda: self.browser and self.browser.find_network(),
            "silence the page": lambda: self.browser and setattr(self.browser, "silent", True),
            "close the page": lambda: self.browser and self.browser.close(),
            "lose the microphone": lambda: self._lose_microphone(True),
            "find the microphone": lambda: self._lose_microphone(False),
            "mute the microphone": lambda: self._mute_microphone(True),
            "unmute the microphone": lambda: self._mute_microphone(False),
            "lose the recognizer": self._lose_recognizer,
            "find the recognizer": lambda: setattr(self, "take_text", self._taking),
            "flood": self._flood,
            "press space": lambda: self.inbox.put(Halt(t=self._now)),
        }
        done[do.what]()

    @property
    def _now(self) -> float:
        return round(self.timeline.now - 1000.0, 4)

    def _renew(self, *, under_way: bool) -> None:
        table = None if under_way else self.given.table
        self.inbox.put(Renewal("list.txt was saved", self._now, under_way, table))

    def _lose_microphone(self, lost: bool) -> None:
        if self.microphone:
            self.microphone.lost = lost

    def _mute_microphone(self, muted: bool) -> None:
        if self.microphone:
            self.microphone.room.muted = muted

    def _lose_recognizer(self) -> None:
        """End its thread: nothing comes from there until it is opened again."""
        self.lose_recognizer("it is gone")
        self.take_text = _take_nothing

    def _flood(self) -> None:
        for _ in range(FLOOD):
            self.take_text(NONSENSE, ROS2_SOURCE)

    def _step(self) -> None:
        self.server.step()
        if self.microphone:
            self.microphone.step()
        if self.browser:
            self.browser.step()
            self.server.step()
        if self._followed:
            self._followed.wait()

    def _end(self) -> None:
        self.inbox.put(End())
        self._hear_no_more()

    def _hear_no_more(self) -> None:
        self._device.close()
        if self._followed:
            self._followed.over = True

    def _page(self, session: Session) -> LivePage:
        address: Any = self.server
        with mock.patch("voz.apps.web.live_page.BrowserMicrophone", self._follow):
            return LivePage(
                session,
                address,
                browser_listens=self._browser_listens,
                now=lambda: self.timeline.now,
            )

    def _follow(self, warn: Callable[[str], None]) -> FollowedMicrophone:
        self._followed = FollowedMicrophone(warn)
        return self._followed

    def _service(self, session: Session, page_drives: Callable[[], bool]) -> Service:
        self.service = Service(session, page_drives, "unix:///")
        return self.service

    @contextmanager
    def _other_recognizer(self, take: TakeText, lost: Callable[[str], None]) -> Iterator[None]:
        self.take_text = self._taking = take
        self.lose_recognizer = lost
        try:
            yield
        finally:
            self._hear_no_more()  # a run that ends by an error waits for the thread that hears

    def continues(self, text: str) -> bool:
        """Whether a space after a typed text is text."""
        texts: Any = self.take_text.__self__  # type: ignore[attr-defined]
        return bool(texts.continues(text))


class Service(RobotService):
    """Wyoming's service without its socket: a client's messages come from the test."""

    def serving(self) -> Any:
        """Serve nobody."""
        return nullcontext()

    def receive(self, event: Event) -> None:
        """Take an event on the test's thread."""
        self._robot.bridge.receive(event)

    async def give(self, text: str) -> None:
        """Give a sentence as Home Assistant does, on a connection of its own."""
        writer: Any = Nowhere()
        guard = ConnectionGuard(WYOMING_PLACES)
        client = CommandHandler(self._robot, guard, asyncio.StreamReader(), writer)
        await client.handle_event(Transcript(text).event())


class Nowhere:
    """A stream to a client who reads nothing."""

    def get_extra_info(self, _: str) -> tuple[str, int]:
        """Return where the client is."""
        return "127.0.0.1", 50_000

    def writelines(self, _: object) -> None:
        """Drop what is written."""

    write = writelines

    async def drain(self) -> None:
        """Wait for nobody."""

    def close(self) -> None:
        """Do nothing."""
