"""Commands that come as text while the robot runs: typed, or from another recognizer."""

from __future__ import annotations

from collections import deque
from collections.abc import Callable

from voz.inbox import Inbox
from voz.language.sentences.command_set import Commands
from voz.language.sentences.spelling import normalize
from voz.run.sources import NO_COMMAND, TYPED, parsed_utterance, read_text

MAX_REFUSED_PER_SECOND = 16
"""Texts a second that are reported as no command, at 2 ms each. More are dropped and counted, so
that a `stop` behind them need not wait."""


class TextCommands:
    """Puts commands that come as text into the inbox of a run, on any thread."""

    def __init__(
        self, commands: Callable[[], Commands], inbox: Inbox, now: Callable[[], float]
    ) -> None:
        """Prepare to take texts; `commands` returns those of now, `now` the time of the run, s."""
        self._commands = commands
        self._inbox = inbox
        self._now = now
        self._refused: deque[float] = deque(
            [-1.0] * MAX_REFUSED_PER_SECOND, MAX_REFUSED_PER_SECOND
        )  # when, s

    def take(self, text: str, source: str = TYPED) -> None:
        """Obey a text as if it were spoken; it may have capitals, digits and a full stop."""
        if normalize(text) in NO_COMMAND:
            return
        commands, now = self._commands(), self._now()
        parse = read_text(text, commands, self._inbox.halts)
        if parse is None:
            if now - self._refused[0] < 1:
                self._inbox.dropped += 1
                return
            self._refused.append(now)
        self._inbox.put(parsed_utterance(text, parse, commands, now, source))

    def continues(self, text: str) -> bool:
        """Return whether a space after a text goes on with a command.

        Not after one that stops the robot, though `stop` may become `stop speech`: the space bar
        then means to stop.
        """
        commands = self._commands()
        parse = commands.parse(text)
        return not (parse and parse.command in self._inbox.halts) and commands.is_typed_prefix(text)
