"""What a page that is opened now has to know of what was before: pure."""

from __future__ import annotations

import json
from collections import deque
from collections.abc import Callable
from typing import Any, TypeAlias

import msgspec

from voz.events import Event, Partial, SelectedObject, Twist, Utterance, explain_not_obeyed

REMEMBERED = 30
"""Utterances, replies and warnings that a page shows which is opened later."""

Record: TypeAlias = dict[str, Any]
"""What is sent to pages, as JSON has it."""


class Board:
    """Turns events into what pages show, and remembers the last of them."""

    def __init__(self, needed: Callable[[str], float | None]) -> None:
        """Begin with nothing.

        Args:
            needed: how sure a command must be to be accepted.
        """
        self._needed = needed
        self._remembered: deque[Record] = deque(maxlen=REMEMBERED)

    @property
    def remembered(self) -> list[Record]:
        """The last that was heard, said and warned of, the oldest first."""
        return list(self._remembered)

    def take(self, event: Event) -> Record:
        """Write an event as pages get it: as in `voz.events`, an utterance with reasons."""
        record: Record = msgspec.to_builtins(event)
        if isinstance(event, Utterance):
            record["needed"] = self._needed(event.text)
            record["why"] = None if event.obeyed else explain_not_obeyed(event)
        if not isinstance(event, Twist | Partial | SelectedObject):
            self._remembered.append(record)
        return record


def encoded(record: Record) -> str:
    """Write a record as JSON; what is no text in it becomes escapes."""
    return json.dumps(record, separators=(",", ":"))
