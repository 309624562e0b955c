"""The node `control_voz`: drives by what any recognizer publishes as strings."""

from __future__ import annotations

import time
from collections.abc import Callable
from functools import partial
from typing import Any, NoReturn

from voz.control.table import CommandTable
from voz.hearing.microphone_thread import SilenceCheck
from voz.inbox import Inbox
from voz.language.language_files import find_language, read_commands
from voz.language.sentences.command_set import Commands, plain_commands
from voz.language.sentences.spelling import normalize
from voz.ros1.control_loop import replies, run_node_session
from voz.ros1.node import Ros1Node, read_settings, run_node, subscribe
from voz.ros1.own_messages import RecognizerStatus, parse_status
from voz.run.clocks import WallClock, warn
from voz.run.command_check import begins_listening, check_list, matched_settings
from voz.run.sources import TextCommands

RECOGNIZER_TIMEOUT = 0.35
"""Limit for messages on `trouble`, s; with the beat, half a second."""


class RecognizerTopic:
    """Puts what a recognizer publishes into an inbox, and watches the recognizer."""

    def __init__(
        self, topic: str, commands: Commands, inbox: Inbox, clock: Callable[[], float]
    ) -> None:
        """Subscribe to a topic of strings, and to `trouble` beside it.

        Strings that are no command are logged. The clock returns the time of the run, s.
        """
        from std_msgs.msg import String

        self._texts = TextCommands(lambda: commands, inbox, clock)
        self._silence = SilenceCheck()
        self._status = RecognizerStatus()
        self._status_at: float | None = None  # on the monotonic clock, s
        self._words = subscribe(topic, String, self._hear, tcp_nodelay=True)
        self.source: str = self._words.resolved_name  # the topic, with its namespace
        self._state = subscribe(f"{self.source.rpartition('/')[0]}/trouble", String, self._note)

    def trouble(self, moving: bool) -> str | None:
        """Return why nothing is heard right now; None if all is well."""
        # rospy keeps the connections of a publisher that was killed, to try them again: they have
        # no socket then.
        if not any(connection.socket for connection in self._words.impl.connections):
            self._status_at = None  # the next one may be another
            return f"no recognizer publishes on {self.source}"
        if self._status_at and time.monotonic() - self._status_at > RECOGNIZER_TIMEOUT:
            return "the recognizer does not answer"
        silent = self._silence.trouble(self._status.only_silence, moving)
        return silent or self._status.problem or None

    def _hear(self, message: Any) -> None:
        self._texts.take(message.data, self.source)

    def _note(self, message: Any) -> None:
        self._status = parse_status(message.data)
        self._status_at = time.monotonic()


def all_commands(table: CommandTable) -> Commands:
    """Return all commands of the table: any recognizer may publish them."""
    return plain_commands(sorted({normalize(n) for names in table.sets.values() for n in names}))


def run_control_voz(node: Ros1Node) -> None:
    """Drive until the node is ended."""
    settings = read_settings()
    listed = read_commands(find_language(settings.lm)) if settings.lm else None
    commands = listed or all_commands(settings.table)
    settings = matched_settings(settings, commands)
    table = settings.table
    inbox = Inbox(table.halts)
    clock = WallClock(inbox)
    check_list(commands, table, settings.lm or "the table of commands")
    topic = RecognizerTopic(settings.ros1.recognizer_output, commands, inbox, clock.now)
    with replies(settings.speech, table, partial(warn, inbox, clock)) as speech:
        run_node_session(
            node,
            settings,
            topic,
            speech.receivers,
            inbox=inbox,
            clock=clock,
            listening=not begins_listening(commands, table),
            says_heard=False,
        )


def main() -> NoReturn:
    """Run the node."""
    run_node("control_voz", run_control_voz)


if __name__ == "__main__":
    main()
