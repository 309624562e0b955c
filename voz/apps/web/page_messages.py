"""The messages of pages and programs; anything else is refused. Pure."""

from __future__ import annotations

from typing import Annotated, TypeAlias

import msgspec

from voz.apps.web.page_playback import MAX_PLAYBACK
from voz.speech.synthesis import MAX_TEXT_LENGTH

MIN_PAGE_RATE, MAX_PAGE_RATE = 8_000, 192_000
"""Sample rates of browsers, Hz."""

ShortText = Annotated[str, msgspec.Meta(max_length=200)]
ReplyText = Annotated[str, msgspec.Meta(max_length=MAX_TEXT_LENGTH)]
Time = Annotated[float, msgspec.Meta(ge=0, le=1e13)]


class Command(msgspec.Struct, frozen=True):
    """POST /api/command: a sentence, and the secret of the driving page.

    Attributes:
        stops: how often the page had asked for a stop before; a command that a stop has overtaken
            on its way is refused.
    """

    text: ShortText
    page: ShortText | None = None
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
    """POST /api/sounding: how long the driving page plays something from now on, s.

    Attributes:
        reply: the reply that it plays; None if it is something else.
    """

    page: ShortText
    seconds: Annotated[float, msgspec.Meta(ge=0, le=MAX_PLAYBACK)]
    reply: ReplyText | None = None


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
