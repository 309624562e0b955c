"""A flood of messages is told of now and then."""

from __future__ import annotations

import pytest

from voz.config import default_commands
from voz.control.controller import ControllerState, Rules
from voz.events import Event, Notice
from voz.inbox import Inbox
from voz.run.dispatcher import Dispatcher
from voz.run.watch import Flood


def flood_lines(dropped: dict[float, int]) -> list[tuple[float, str]]:
    """What is told of a flood: by the time of each look (s), what was dropped so far."""
    events: list[Event] = []
    controller = Dispatcher(ControllerState(Rules(default_commands())), [events.append])
    inbox = Inbox(set())
    flood = Flood(controller, inbox)
    for t, inbox.dropped in dropped.items():
        flood.check(t)
    return [(event.t, event.text) for event in events if isinstance(event, Notice)]


def test_a_flood_is_one_line_when_it_is_over() -> None:
    looks = {20 + t / 10: min(max(t - 3, 0), 4) * 100 for t in range(100)}
    assert flood_lines(looks) == [(20.8, "400 messages came too fast and were dropped")]


@pytest.mark.parametrize("first", [0, 1])
def test_a_flood_without_an_end_is_a_line_now_and_then(first: int) -> None:
    lines = flood_lines({t / 10: t * 100 for t in range(first, 160)})
    assert [t for t, _ in lines] == [5.0, 10.0, 15.0]
    assert lines[1][1] == "5000 messages came too fast and were dropped"
