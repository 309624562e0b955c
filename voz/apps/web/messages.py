"""What pages send, checked: anything else is refused. Pure."""

from __future__ import annotations

from typing import Annotated, TypeAlias

import msgspec

from voz.apps.web.sound import HIGHEST_RATE, LOWEST_RATE
from voz.apps.web.sounding import LONGEST

Short = Annotated[str, msgspec.Meta(max_length=200)]
Time = Annotated[float, msgspec.Meta(ge=0, le=1e13)]


class Command(msgspec.Struct, frozen=True):
    """POST /api/command: a sentence, and the secret of the page that drives.

    Attributes:
        stops: how often the page had asked for a stop before; a command that a stop has overtaken
            on its way is refused.
    """

    text: Short
    page: Short | None = None
    stops: int | None = None


class Mark(msgspec.Struct, frozen=True):
    """POST /api/mark: what was said in a recording, None if no command; by the page that drives."""

    page: Short
    file: Short
    said: Short | None


class Alarms(msgspec.Struct, frozen=True):
    """POST /api/alarms: how many there may be in an hour of talk; by the page that drives."""

    page: Short
    alarms: Annotated[float, msgspec.Meta(gt=0, le=1e4)]


class Playing(msgspec.Struct, frozen=True):
    """POST /api/sounding: for how long the page that drives plays something from now on, s."""

    page: Short
    seconds: Annotated[float, msgspec.Meta(ge=0, le=LONGEST)]


class Login(msgspec.Struct, frozen=True):
    """POST /api/login: the token of the link."""

    token: Short


class Seen(msgspec.Struct, frozen=True, tag_field="type", tag="seen"):
    """The page has shown a state."""


class Drive(msgspec.Struct, frozen=True, tag_field="type", tag="drive"):
    """The page wants to drive, perhaps in place of another."""

    over: bool = False


class Leave(msgspec.Struct, frozen=True, tag_field="type", tag="leave"):
    """The page drives no more."""


class Stop(msgspec.Struct, frozen=True, tag_field="type", tag="stop"):
    """The robot is to stop; the answer has the same number."""

    number: int = 0


class Rehearse(msgspec.Struct, frozen=True, tag_field="type", tag="rehearse"):
    """Commands are to be understood, but none is to be obeyed; or they are again."""

    on: bool


FromPage: TypeAlias = Seen | Drive | Leave | Stop | Rehearse


class Hello(msgspec.Struct, frozen=True, tag_field="type", tag="hello"):
    """A page wants to be heard: its secret, and the rate of its sound, Hz."""

    page: Short
    rate: Annotated[float, msgspec.Meta(ge=LOWEST_RATE, le=HIGHEST_RATE)]


class Begin(msgspec.Struct, frozen=True, tag_field="type", tag="begin"):
    """Sound follows."""


class Finish(msgspec.Struct, frozen=True, tag_field="type", tag="end"):
    """No more sound follows."""


class Pong(msgspec.Struct, frozen=True, tag_field="type", tag="pong"):
    """The answer to a ping: its time, s, and that of the page, ms."""

    t: Time
    at: Time


FromMicrophone: TypeAlias = Hello | Begin | Finish | Pong
