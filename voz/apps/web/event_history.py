"""Events as pages get them, and the last of them, for a page that is opened later: pure."""

from __future__ import annotations

import json
from collections import deque
from collections.abc import Callable
from typing import Any, TypeAlias

import msgspec

from voz.events import Event, Partial, SelectedObject, Twist, Utterance, explain_not_obeyed

MAX_REMEMBERED = 30
"""Utterances, replies and warnings that a page shows which is opened later."""

Record: TypeAlias = dict[str, Any]
"""What is sent to pages, as JSON has it."""


class EventHistory:
    """Turns events into records for pages, and remembers the last."""

    def __init__(self, threshold: Callable[[str], float | None]) -> None:
        """Begin empty; `threshold` returns the confidence that a command needs."""
        self._threshold = threshold
        self._remembered: deque[Record] = deque(maxlen=MAX_REMEMBERED)

    @property
    def remembered(self) -> list[Record]:
        """The last utterances, replies and warnings, the oldest first."""
        return list(self._remembered)

    def add(self, event: Event) -> Record:
        """Return an event's fields as in `voz.events`, of an utterance `needed` and `why` too."""
        record: Record = msgspec.to_builtins(event)
        if isinstance(event, Utterance):
            record["needed"] = self._threshold(event.text)
            record["why"] = None if event.obeyed else explain_not_obeyed(event)
        if not isinstance(event, Twist | Partial | SelectedObject):
            self._remembered.append(record)
        return record


def encode_record(record: Record) -> str:
    """Write a record as ASCII JSON: even a lone surrogate can be sent."""
    return json.dumps(record, separators=(",", ":"))
