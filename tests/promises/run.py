"""What a run of the matrix is given, what is done in it, and what came of it."""

from __future__ import annotations

import functools
from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import Any, Protocol

import msgspec

import voz
from voz.api.recognizer import Recognizer
from voz.config import Config
from voz.control.table import CommandTable
from voz.events import Event, Notice, Receiver, Reply, Twist, Utterance
from voz.settings import Ask, Recognition, Safety, Speech

NAME = "hey robot"

ROS2_SOURCE = "ros2"
"""As `voz.ros2.other_recognizer` has it, which needs Cyclone DDS."""

STEPS: dict[str, dict[str, Any]] = {
    "light on": {"publish": True, "topic": "light"},
    "dance": {"run": ["true"]},
    "wave": {"call": ["promises.exits:wave", "Ana"]},
    "greet": {"say": "hello"},
}
"""Commands for each exit besides velocities."""

OWN = "open gripper"
"""A command that only the robot's own code knows."""


def surely(text: str) -> str:
    """The command that does the same as another, and asks first."""
    return f"surely {text}"


COMMANDS: dict[str, dict[str, Any]] = {
    **STEPS,
    **{surely(text): {**step, "confirm": "sure?"} for text, step in STEPS.items()},
    surely("go forward"): {"drive": 0.1, "confirm": "sure?"},
    surely(OWN): {"confirm": "sure?"},
    "run fast": {"drive": 0.5},
    "fly away": {"drive": 0.2, "confirm": "shall I fly?"},
    "make coffee": {"confirm": True},
    "yes": {"answer": True},
    "no": {"answer": False},
}
"""Besides voz's own: a fast one, and two that ask first, one for the robot's own code."""

LIST = [*voz.load().commands, *COMMANDS, OWN]


@dataclass(frozen=True)
class Given:
    """How a run begins."""

    name: str = ""  # what the robot is called; empty if all commands count
    ask: Ask = "never"  # what it asks back
    listening: bool = True  # whether it obeys from the beginning
    safety: Safety = field(default_factory=Safety)  # the limits
    raises: bool = False  # whether a receiver before the robot raises as soon as that moves
    exits: Sequence[Receiver] = ()  # what else gets the events, behind it

    def receivers(self, outcome: Outcome) -> list[Receiver]:
        """Return what gets the events."""
        return [*([_break] if self.raises else []), outcome.events.append, *self.exits]

    @property
    def settings(self) -> Config:
        """The settings of the run."""
        recognition = Recognition(name=self.name, ask=self.ask)
        tables: dict[str, Any] = {"commands": COMMANDS}
        config = msgspec.convert(tables, Config)
        return msgspec.structs.replace(
            config, safety=self.safety, recognition=recognition, speech=Speech(enabled=False)
        )

    @property
    def table(self) -> CommandTable:
        """What the commands do."""
        return self.settings.table


@functools.cache
def recognizer_for(name: str, ask: Ask) -> Recognizer:
    """Load what hears the commands, once."""
    return voz.load(LIST, Recognition(name=name, ask=ask))


@dataclass(frozen=True)
class Do:
    """Something that is done in a run: when, s, what, and with what text."""

    at: float
    what: str
    text: str = ""


@dataclass
class Outcome:
    """What the robot got."""

    events: list[Event] = field(default_factory=list)  # all of them
    error: BaseException | None = None  # what ended the run, if not its end

    @property
    def twists(self) -> list[Twist]:
        """The velocities, in order."""
        return [event for event in self.events if isinstance(event, Twist)]

    @property
    def obeyed(self) -> list[str]:
        """The names of the commands that took effect."""
        return [e.name for e in self.events if isinstance(e, Utterance) and e.obeyed]

    @property
    def ignored(self) -> list[str | None]:
        """Why the others that were understood had none."""
        heard = [e for e in self.events if isinstance(e, Utterance) and e.accepted]
        return [event.ignored for event in heard if not event.obeyed]

    @property
    def said(self) -> list[str]:
        """What the robot said."""
        return [event.text for event in self.events if isinstance(event, Reply)]

    @property
    def warnings(self) -> list[str]:
        """What it warned of."""
        return [event.text for event in self.events if isinstance(event, Notice)]

    def moving(self, begin: float, end: float = float("inf")) -> list[Twist]:
        """The velocities that move it, sent between two times, s."""
        return [t for t in self.twists if begin <= t.t < end and (t.linear or t.angular)]

    def stood_at(self, after: float) -> float:
        """When it stood, if it has stood ever since: after a time, s."""
        last = max((t.t for t in self.moving(after)), default=after)
        return next((t.t for t in self.twists if t.t > last), float("inf"))

    def meters(self, begin: float, end: float) -> float:
        """How far it came between two times, s, each velocity held until the next, m."""
        held = zip(self.twists, self.twists[1:], strict=False)
        spans = ((one, max(begin, one.t), min(end, other.t)) for one, other in held)
        return sum(abs(one.linear) * max(0.0, until - since) for one, since, until in spans)


def _break(event: Event) -> None:
    """Print what moves into a pipe that nobody reads."""
    if isinstance(event, Twist) and event.linear:
        raise BrokenPipeError


class Door(Protocol):
    """A way by which commands come in."""

    name: str  # in the table
    spoken: bool  # whether they are said, and heard by the recognizer
    needs_name: bool  # whether a robot with a name has to be called by it
    reach: float  # so long a command takes from its first sound or letter until it takes effect, s
    watched: bool  # whether who commands by it watches the robot, or is watched
    cannot: dict[str, str]  # which promises cannot be kept or broken here, and why

    def run(self, given: Given, script: Sequence[Do], seconds: float) -> Outcome:
        """Do what the script says in a run of so many seconds."""
