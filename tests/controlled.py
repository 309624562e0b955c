"""A controller step by step: its state, and all events that came of its messages."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from voz.control.controller import change_rules
from voz.control.messages import Halt, Health, Rehearsal
from voz.control.motion import Place
from voz.control.table import CommandTable
from voz.events import Event
from voz.run.controller import Controller
from voz.settings import Safety


class Controlled(Controller):
    """Keeps the events; attributes of `Rules` may be given."""

    def __init__(
        self,
        safety: Safety | None = None,
        listening: bool = True,
        table: CommandTable | None = None,
        odometry: Callable[[float], Place | None] = lambda _: None,
        **rules: Any,
    ) -> None:
        self.events: list[Event] = []  # all so far
        super().__init__([self.events.append], safety, listening, table, odometry)
        self.change_rules(**rules)

    def press(self, now: float, pressed: float | None = None) -> None:
        """Stop by a key; when it was pressed may not be known."""
        self.take(Halt() if pressed is None else Halt(t=pressed), now)

    def lose(self, now: float, problem: str | None, name: str = "a", *sources: str) -> None:
        """Lose something, or find it again."""
        self.take(Health(name, problem, f"{name} is there", sources), now)

    def rehearse(self, on: bool = True) -> None:
        """Begin or end a rehearsal."""
        self.take(Rehearsal(on), 0.0)

    def change_rules(self, **changes: Any) -> None:
        """Control by other rules."""
        self.state = change_rules(self.state, **changes)
