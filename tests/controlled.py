"""A controller step by step: its state, and all events that came of its messages."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from voz.config import default_commands
from voz.control.controller import ControllerState, Rules, change_rules
from voz.control.messages import Beat, Halt, Health, Rehearsal, StopMotion, too_late
from voz.control.motion import Place
from voz.control.state_machine import State
from voz.control.table import CommandTable
from voz.events import Event, Partial, Utterance
from voz.run.dispatcher import Dispatcher
from voz.settings import Safety


class Controlled(Dispatcher):
    """Keeps the events; attributes of `Rules` may be given."""

    def __init__(
        self,
        safety: Safety | None = None,
        listening: bool = True,
        table: CommandTable | None = None,
        odometry: Callable[[float], Place | None] = lambda _: None,
        **rules: Any,
    ) -> None:
        rules = {"table": table or default_commands(), "safety": safety or Safety(), **rules}
        state = ControllerState(Rules(**rules), State(listening=listening))
        self.events: list[Event] = []  # all so far
        super().__init__(state, [self.events.append], odometry)

    def hear(self, event: Utterance | Partial, late: bool = False) -> None:
        """Let an utterance or a partial take effect."""
        message: Any = too_late(event) if late else event
        self.take(message, event.t)

    def send(self, now: float) -> None:
        """Let time pass."""
        self.take(Beat(), now)

    def stop(self, now: float, why: str) -> None:
        """End the motion until a new command."""
        self.take(StopMotion(why), now)

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
