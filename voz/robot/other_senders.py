"""Tells of other programs that drive the same base: it obeys them too after a `stop` of voz."""

from __future__ import annotations

from collections.abc import Callable, Set

from voz.events import Notice

ONE_SENDER = "let only one program send, or a multiplexer such as twist_mux choose"
"""What to do about two."""


class OtherSenders:
    """Makes a warning of each that comes, and good news of each that goes. Pure."""

    def __init__(self, topic: str, warn: Callable[[Notice], None]) -> None:
        """Begin with nobody; the topic's name is for messages."""
        self._topic = topic
        self._warn = warn
        self._known: Set[str] = frozenset()

    def update(self, now: float, names: Set[str]) -> None:
        """Note who sends now, by names for people; `now` is the time of the run, s."""
        for name in sorted(names - self._known):
            text = f"{name} sends velocities on {self._topic} too: {ONE_SENDER}"
            self._warn(Notice(now, text))
        for name in sorted(self._known - names):
            self._warn(Notice(now, f"{name} left {self._topic}", good=True))
        self._known = names
