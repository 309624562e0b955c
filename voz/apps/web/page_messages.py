"""The messages of pages and programs, and the records that pages get; anything else is refused.

Pure.
"""

from __future__ import annotations

import json
from collections import deque
from collections.abc import Callable
from typing import Annotated, Any, TypeAlias

import msgspec

from voz.events import Attention, Event, Notice, Reply, Utterance, explain_not_obeyed
from voz.speech.synthesis import MAX_TEXT_LENGTH

PAGE_SOURCE = "page"
"""The source of a command of the page that drives, or of a program that is watched like one."""

PROGRAM_SOURCE = "program"
"""The source of a command that was posted while no page drives: nobody knows whether its sender is
still there."""

MAX_PLAYBACK = 30.0
"""The longest sound that a page may play, s: no recording is longer."""

MIN_PAGE_RATE, MAX_PAGE_RATE = 8_000, 192_000
"""Sample rates of browsers, Hz."""

ShortText = Annotated[str, msgspec.Meta(max_length=200)]
ReplyText = Annotated[str, msgspec.Meta(max_length=MAX_TEXT_LENGTH)]
Time = Annotated[float, msgspec.Meta(ge=0, le=1e13)]


class Command(msgspec.Struct, frozen=True):
    """POST /api/command: a sentence, and the secret of the driving page."""

    text: ShortText
    page: ShortText | None = None
    # How often the page had asked for a stop before; a command that a stop has overtaken on its way
    # is refused.
    stops: int | None = None


class Mark(msgspec.Struct, frozen=True):
    """POST /api/mark: what was said in a recording, None for no command; by the driving page."""

    page: ShortText
    file: ShortText
    said: ShortText | None


class Alarms(msgspec.Struct, frozen=True):
    """POST /api/alarms: false alarms allowed per hour of talk; by the driving page."""

    page: ShortText
    alarms: Annotated[float, msgspec.Meta(gt=0, le=1e4)]


class Playing(msgspec.Struct, frozen=True):
    """POST /api/sounding: how long the driving page plays something from now on, s."""

    page: ShortText
    seconds: Annotated[float, msgspec.Meta(ge=0, le=MAX_PLAYBACK)]
    reply: ReplyText | None = None  # the reply that it plays; None if it is something else


class Login(msgspec.Struct, frozen=True):
    """POST /api/login: the token of the link."""

    token: ShortText


class Seen(msgspec.Struct, frozen=True, tag_field="type", tag="seen"):
    """The page has shown a state."""


class Drive(msgspec.Struct, frozen=True, tag_field="type", tag="drive"):
    """The page wants to drive; `over`: also in place of another."""

    over: bool = False


class Leave(msgspec.Struct, frozen=True, tag_field="type", tag="leave"):
    """The page drives no more."""


class Stop(msgspec.Struct, frozen=True, tag_field="type", tag="stop"):
    """Stop the robot; the answer has the same number."""

    number: int = 0


class Rehearse(msgspec.Struct, frozen=True, tag_field="type", tag="rehearse"):
    """Begin or end a rehearsal, in which no command but `stop` is obeyed."""

    on: bool


FromPage: TypeAlias = Seen | Drive | Leave | Stop | Rehearse


class Hello(msgspec.Struct, frozen=True, tag_field="type", tag="hello"):
    """A page wants to be heard: its secret, and its sample rate, Hz."""

    page: ShortText
    rate: Annotated[float, msgspec.Meta(ge=MIN_PAGE_RATE, le=MAX_PAGE_RATE)]


class Begin(msgspec.Struct, frozen=True, tag_field="type", tag="begin"):
    """Sound follows; `held`: a button is held meanwhile, so what is said is meant for the robot."""

    held: bool = False


class Finish(msgspec.Struct, frozen=True, tag_field="type", tag="end"):
    """No more sound follows."""


class Pong(msgspec.Struct, frozen=True, tag_field="type", tag="pong"):
    """The answer to a ping: the ping's time, s, and the page's, ms."""

    t: Time
    at: Time


FromMicrophone: TypeAlias = Hello | Begin | Finish | Pong


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
