"""What passes to the controller besides events, and which messages overtake others. Pure."""

from __future__ import annotations

from collections.abc import Collection
from typing import TypeAlias, TypeVar

import msgspec
from msgspec.structs import replace

from voz.control.table import CommandTable
from voz.events import Notice, Partial, ProgramEnded, Utterance


class Halt(msgspec.Struct, frozen=True):
    """The robot is to stand still, by a key or a button; what was begun before moves nothing."""

    why: str = "stopped by a key"  # for people
    t: float = 0.0  # time of the run, s


class Rehearsal(msgspec.Struct, frozen=True):
    """Begin or end a rehearsal: commands are understood, but not obeyed. Never dropped."""

    on: bool


class Renewal(msgspec.Struct, frozen=True):
    """The commands are being renewed, or were: meanwhile nothing moves. Never dropped."""

    why: str  # for people
    t: float  # time of the run, s
    under_way: bool  # whether it has begun, else it is over
    table: CommandTable | None = None  # what the commands do from now on; None if all is as before


class End(msgspec.Struct, frozen=True):
    """The run is over, or has failed by an error. Never dropped."""

    error: BaseException | None = None


class StopMotion(msgspec.Struct, frozen=True):
    """The motion ends until a new command; older ones move nothing. `why` is for people."""

    why: str


class Health(msgspec.Struct, frozen=True):
    """Whether something that the run needs works (S5): a microphone, a page, a robot."""

    name: str  # which
    problem: str | None  # why it is lost; None if it works
    back: str  # the message when it works again
    # Of the commands that come from it; while it is lost they move nothing.
    sources: tuple[str, ...] = ()


class Beat(msgspec.Struct, frozen=True):
    """Time has passed: velocities are due."""


Message: TypeAlias = Utterance | Partial | ProgramEnded | Notice | Halt | Rehearsal | Renewal | End
"""What passes through an inbox."""

ControllerMessage: TypeAlias = (
    Utterance
    | Partial
    | ProgramEnded
    | Notice
    | Halt
    | Rehearsal
    | Renewal
    | StopMotion
    | Health
    | Beat
)
"""What the controller takes."""


AnyMessage = TypeVar("AnyMessage", bound=Message)


def overtakes(message: Message, halts: Collection[str]) -> bool:
    """Whether a message comes before those that wait: what stops the robot, of commands `halts`."""
    if isinstance(message, Utterance):
        return message.accepted and message.name in halts
    if isinstance(message, Partial):
        return message.name in halts
    return not isinstance(message, ProgramEnded | Notice)


def may_be_dropped(message: Message) -> bool:
    """Whether a message may be lost where too many wait."""
    return not isinstance(message, Rehearsal | Renewal | End)


def too_late(message: AnyMessage) -> AnyMessage:
    """Mark a command as out of date, as one that was overtaken by a stop: it moves nothing."""
    if isinstance(message, Utterance) and message.accepted:
        return replace(message, ignored="too_late")
    return message
