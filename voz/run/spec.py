"""What a run consists of: the one record from which a `Session` opens everything."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from contextlib import AbstractContextManager
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, TypeAlias

from voz.config import Config
from voz.inbox import Inbox
from voz.run.clocks import Clock, WallClock

if TYPE_CHECKING:
    from voz.run.controller import Controller
    from voz.run.session import Session

Part: TypeAlias = Callable[["Session"], AbstractContextManager[object]]
"""Opens something for a `with` block, and adds to the session what it receives or watches."""


@dataclass(frozen=True, kw_only=True)
class RunSpec:
    """What a run consists of.

    Attributes:
        controller: obeys, with the robot at rest.
        settings: of the robots, the voice and the rest.
        outputs: opened first: the robots, and files of events. Then the time of the run begins.
        clock: makes the clock of the run, and begins it.
        in_real_time: whether that is a real one; without it each run gives the same events.
        parts: opened after that, in this order: what speaks, what commands come from.
        inbox: takes messages; None makes one.
    """

    controller: Controller
    settings: Config = field(default_factory=Config)
    outputs: Sequence[Part] = ()
    clock: Callable[[Inbox], Clock] = WallClock
    in_real_time: bool = True
    parts: Sequence[Part] = ()
    inbox: Inbox | None = None
