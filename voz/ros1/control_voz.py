"""The node `control_voz`: drives by what any recogniser publishes as strings."""

from __future__ import annotations

import time
from collections.abc import Callable
from queue import SimpleQueue
from typing import Any, NoReturn

from voz.control.controller import OBJECTS, RULES
from voz.language.commands import normalise
from voz.live.loop import stamp
from voz.live.messages import Inbox, Message
from voz.pipeline import typed
from voz.ros1.driving import drive
from voz.ros1.node import Node
from voz.ros1.parameters import read_settings
from voz.ros1.program import clock_from_now, run_node
from voz.ros1.replies import replies

COMMANDS = {*RULES, *OBJECTS, "start speech", "stop speech"}
"""What has an effect; other strings are logged."""

STALE = 0.35
"""Without a word from a recogniser that tells how it is, s; with the beat, half a second."""


class RemoteEars:
    """What a recogniser publishes, as messages in an inbox, and whether there is one."""

    def __init__(self, topic: str, inbox: Inbox, clock: Callable[[], float]) -> None:
        """Subscribe to it.

        Args:
            topic: of its strings; voz's own tells beside it, on `trouble`, how it is.
            inbox: where they go.
            clock: the time of the run, s.
        """
        from rospy import Subscriber
        from std_msgs.msg import String

        self._inbox = inbox
        self._clock = clock
        self._problem = ""
        self._told: float | None = None  # on the monotonic clock, s
        self._words = Subscriber(topic, String, self._hear, tcp_nodelay=True)
        self.topic: str = self._words.resolved_name
        self._state = Subscriber(f"{self.topic.rpartition('/')[0]}/trouble", String, self._note)

    def trouble(self) -> str | None:
        """Tell why nothing is heard right now; None if all is well."""
        # rospy keeps the connections of a publisher that was killed, to try them again: they have
        # no socket then.
        if not any(connection.socket for connection in self._words.impl.connections):
            self._told = None  # the next one may be another
            return f"no recogniser publishes on {self.topic}"
        if self._told is not None and time.monotonic() - self._told > STALE:
            return "the recogniser does not answer"
        return self._problem or None

    def _hear(self, message: Any) -> None:
        text = normalise(message.data)
        if text:
            self._inbox.put(typed(text, text in COMMANDS, stamp(self._clock()), self.topic))

    def _note(self, message: Any) -> None:
        self._problem = message.data
        self._told = time.monotonic()


def control(node: Node) -> None:
    """Drive until the node is ended."""
    settings = read_settings()
    inbox: SimpleQueue[Message] = SimpleQueue()
    clock = clock_from_now()
    ears = RemoteEars(settings.ros1.recognizer_output, inbox, clock)
    with replies(settings.speech) as speech:
        drive(node, settings, speech, inbox, clock, ears.trouble, says_heard=False)


def main() -> NoReturn:
    """Run the node."""
    run_node("control_voz", control)


if __name__ == "__main__":
    main()
