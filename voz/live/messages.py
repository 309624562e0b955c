"""What the threads at the edges put into the inbox of the loop that drives the robot."""

from __future__ import annotations

from queue import SimpleQueue
from typing import NamedTuple, TypeAlias

from voz.events import Partial, Utterance, Warning


class Halt(NamedTuple):
    """Somebody wants the robot to stand still, by a key."""


Message: TypeAlias = Utterance | Partial | Warning | Halt

Inbox: TypeAlias = "SimpleQueue[Message]"
