"""Events as pages get them, and the last of them, for a page that is opened later: pure."""

from __future__ import annotations

import json
from collections import deque
from collections.abc import Callable
from typing import Any, TypeAlias

import msgspec

from voz.events import Attention, Event, Notice, Reply, Utterance, explain_not_obeyed

MAX_REMEMBERED = 30
"""Utterances, replies and warnings that a page shows which is opened later."""

SHOWN_EVENTS = (Utterance, Reply, Notice)
"""What a page shows in words."""

Record: TypeAlias = dict[str, Any]
"""What is sent to pages, as JSON has it."""


class EventHistory:
    """Turns events into records for pages, and remembers the last.

    Attributes:
        answers: what may be said to the robot's question; empty if it has asked nothing.
    """

    def __init__(self, threshold: Callable[[str], float | None]) -> None:
        """Begin empty; `threshold` returns the confidence that a command needs."""
        self._threshold = threshold
        self._remembered: deque[Record] = deque(maxlen=MAX_REMEMBERED)
        self._said = ""  # by the robot, last
        self.answers: tuple[str, ...] = ()

    @property
    def remembered(self) -> list[Record]:
        """The last utterances, replies and warnings, the oldest first."""
        return list(self._remembered)

    @property
    def question(self) -> str:
        """What the robot has asked, while `answers` are open."""
        return self._said if self.answers else ""

    def add(self, event: Event) -> Record:
        """Return an event's fields as in `voz.events`, of an utterance `needed` and `why` too."""
        record: Record = msgspec.to_builtins(event)
        if isinstance(event, Utterance):
            record["needed"] = self._threshold(event.text)
            record["why"] = None if event.obeyed else explain_not_obeyed(event)
        if isinstance(event, Reply):
            self._said = event.text
        elif isinstance(event, Attention):
            self.answers = event.answers
        if isinstance(event, SHOWN_EVENTS):
            self._remembered.append(record)
        return record


def encode_record(record: Record) -> str:
    """Write a record as ASCII JSON: even a lone surrogate can be sent."""
    return json.dumps(record, separators=(",", ":"))
