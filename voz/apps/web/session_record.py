"""A recorded session as its page gets it: pure."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TypeAlias

from voz.apps.web.event_history import EventHistory, Record
from voz.apps.web.picture import DeadReckoningPicture
from voz.events import Event, Partial, SelectedObject, Twist

State: TypeAlias = list[float | int | None]
"""Time (s), x and y (m), heading (rad), speed (m/s), turning (rad/s), selected object or None."""


def session_record(name: str, events: Sequence[Event]) -> Record:
    """Return what was heard and said, and where the robot was according to its velocities.

    Args:
        name: of the session.
        events: in their order, one at least.

    Returns:
        `states` has one for each change, `events` are as pages get them.
    """
    history = EventHistory(lambda _: None)
    shown = [history.add(e) for e in events if not isinstance(e, Twist | Partial | SelectedObject)]
    return {
        "name": name,
        "begin": events[0].t,
        "end": max(event.t for event in events),
        "states": _states(events),
        "events": shown,
    }


def _states(events: Sequence[Event]) -> list[State]:
    picture = DeadReckoningPicture()
    states: list[State] = []
    for event in events:
        picture.receive(event)
        if isinstance(event, Twist):
            robot = picture.state()
            state = [event.t, *robot["pose"], event.linear, event.angular, robot["selected"]]
            if not states or states[-1][1:] != state[1:]:
                states.append(state)
    return states
