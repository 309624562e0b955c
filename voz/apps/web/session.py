"""What the page shows of a session that was kept: pure."""

from __future__ import annotations

from collections.abc import Sequence

from voz.apps.web.board import Board, Record
from voz.apps.web.picture import ReckonedPicture
from voz.events import Event, Partial, SelectedObject, Twist

State = list[float | int | None]
"""When, s; where and which way, m and rad; how fast, m/s and rad/s; which object, if any."""


def session_record(name: str, events: Sequence[Event]) -> Record:
    """Tell what was heard and said, and where the robot was by what it was asked for.

    Args:
        name: of the session.
        events: in their order, one at least.

    Returns:
        `states` has one wherever something changed, `events` are as pages get them.
    """
    board = Board(lambda _: None)
    told = [board.take(e) for e in events if not isinstance(e, Twist | Partial | SelectedObject)]
    return {
        "name": name,
        "begin": events[0].t,
        "end": max(event.t for event in events),
        "states": _states(events),
        "events": told,
    }


def _states(events: Sequence[Event]) -> list[State]:
    picture = ReckonedPicture()
    states: list[State] = []
    for event in events:
        picture.receive(event)
        if isinstance(event, Twist):
            seen = picture.look()
            state = [event.t, *seen["pose"], event.linear, event.angular, seen["selected"]]
            if not states or states[-1][1:] != state[1:]:
                states.append(state)
    return states
