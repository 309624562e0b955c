"""The operator page as a part of a run, without a server."""

from __future__ import annotations

import time
from typing import Any

import pytest

import voz
from voz.apps.web.live_page import NO_DRIVER, LivePage
from voz.control.messages import Halt
from voz.events import Event, Notice, Utterance
from voz.inbox import Inbox
from voz.run.clocks import WallClock
from voz.run.session import Session
from voz.run.spec import RunSpec


@pytest.mark.parametrize("listens", [True, False])
def test_s5_what_is_still_to_be_settled_when_the_page_closes_moves_nothing(listens: bool) -> None:
    events: list[Event] = []
    controller = voz.Controller([events.append], listening=True)
    inbox = Inbox({"stop"})
    session = Session(RunSpec(controller=controller, inbox=inbox))
    session.clock = clock = WallClock(inbox)
    address: Any = None  # it is not served
    page = LivePage(session, address, browser_listens=listens)
    page.driver_lock.acquire(1, False, time.monotonic())
    begun = clock.now()
    time.sleep(0.02)
    page.driver_lock.release(1)
    assert page.trouble(controller.moving) is None
    while (message := inbox.take(0.001)) is not None:
        assert isinstance(message, Halt | Utterance)
        controller.take(message, clock.now())
    told = [event.text for event in events if isinstance(event, Notice)]
    assert told == ([NO_DRIVER] if listens else [])
    now = clock.now()
    controller.hear(Utterance(now, "go forward", 0.9, True, begun, now, "browser"))
    assert controller.moving is not listens  # else the robot's own microphone may have heard it
