"""Whether a command that stops was said just now, whatever sounds before and after it."""

from __future__ import annotations

from collections.abc import Collection, Iterable
from typing import NamedTuple

from voz.audio import SAMPLE_RATE, Samples
from voz.audio.endpointing.segment import MAX_WORD_SECONDS
from voz.recognition.phoneme_scorer import PhonemeScorer

FITS = 8.0
"""Nats of the network: a command with so much evidence for it may have been said."""


class Spotted(NamedTuple):
    """A command that may have been said just now, and the evidence for it, nats."""

    text: str
    score: float


class Spotter:
    """Looks for some commands in what was heard last, with the second ear alone."""

    def __init__(
        self, ear: PhonemeScorer, commands: Collection[str], others: Iterable[str]
    ) -> None:
        """Start to look.

        Args:
            ear: knows how they are pronounced.
            commands: what it looks for, at least one.
            others: commands that might be taken for one of them.
        """
        self._ear = ear
        self._commands = commands
        self._others = [other for other in others if other not in commands]
        most_words = max(len(command.split()) for command in commands)
        self._window = int(MAX_WORD_SECONDS * SAMPLE_RATE) * most_words

    def spot(self, so_far: Samples) -> Spotted | None:
        """Tell which of the commands, if any, is in what was heard last.

        Args:
            so_far: what stands out of the room, up to now, 16 kHz.
        """
        sounds = self._ear.phone_likelihoods(so_far[-self._window :])
        ranking = self._ear.rank(sounds, [*self._commands, *self._others])
        found = ranking.text in self._commands and ranking.score > FITS
        return Spotted(ranking.text, ranking.score) if found else None
