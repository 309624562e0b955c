"""Which commands are compared: all of a short list, similar ones of a long list."""

from __future__ import annotations

from collections.abc import Collection

from voz.language.similarity import WordDistances
from voz.recognition.accents import spellings
from voz.recognition.language import Language

MAX_NEVER_MISSED = 8
"""Sentences of each template that must not be missed which are always compared."""


class Shortlist:
    """Chooses the commands that are compared; those of `never_missed` always are."""

    def __init__(self, language: Language, never_missed: Collection[str], most: int) -> None:
        """Prepare for a language, commands that are always compared, and the most to compare."""
        self._commands = language.commands
        self._most = most
        self._sound = WordDistances(spellings(language.pronunciations), language.spoken.distances)
        self.never_missed = self._commands.named(never_missed, MAX_NEVER_MISSED)

    @property
    def is_whole(self) -> bool:
        """Whether all commands are compared."""
        return len(self._commands) <= self._most

    def similar_to(self, text: str) -> list[str]:
        """The whole list, or a command and those that sound like it; empty text is no command."""
        if self.is_whole:
            return self._commands.listed
        if not text:
            return self.never_missed
        near = self._commands.neighbors(text, self._most, self._sound)
        return list(dict.fromkeys([text, *self.never_missed, *near]))[: self._most]
