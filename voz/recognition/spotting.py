"""Keyword spotting: whether a command that stops was said just now, amid any sound."""

from __future__ import annotations

from collections.abc import Collection, Iterable
from dataclasses import dataclass

from voz.audio import SAMPLE_RATE, Samples
from voz.audio.endpointing.segment import MAX_WORD_SECONDS
from voz.recognition.phoneme_scorer import PhonemeScorer

MIN_SPOTTING_SCORE = 8.0
"""A command with a higher score may have been said, nats."""


@dataclass(frozen=True)
class SpottedCommand:
    """A command that may have been said, and its score, nats."""

    text: str
    score: float


class KeywordSpotter:
    """Looks for a few commands in the latest sound, by the network alone."""

    def __init__(
        self, scorer: PhonemeScorer, commands: Collection[str], others: Iterable[str]
    ) -> None:
        """Prepare to look for commands, at least one, that others may be taken for."""
        self._scorer = scorer
        self._commands = commands
        self._others = [other for other in others if other not in commands]
        most_words = max(len(command.split()) for command in commands)
        self._window = int(MAX_WORD_SECONDS * SAMPLE_RATE) * most_words

    def spot(self, so_far: Samples) -> SpottedCommand | None:
        """Find a command in the latest sound, 16 kHz."""
        sounds = self._scorer.phone_likelihoods(so_far[-self._window :])
        ranking = self._scorer.rank(sounds, [*self._commands, *self._others])
        found = ranking.text in self._commands and ranking.score > MIN_SPOTTING_SCORE
        return SpottedCommand(ranking.text, ranking.score) if found else None
