"""Keyword spotting: whether a command that stops was said just now, amid any sound."""

from __future__ import annotations

import math
from collections.abc import Collection, Iterable
from dataclasses import dataclass, replace

import numpy as np

from voz.audio import SAMPLE_RATE, Samples
from voz.audio.echo import Cleaned
from voz.audio.segment import MAX_WORD_SECONDS
from voz.recognition.phoneme_scorer import MAX_LEAD_BONUS, PhoneLikelihoods, PhonemeScorer

MIN_SPOTTING_SCORE = 8.0
"""A command with a higher score may have been said, nats."""

MIN_SCORE_WITHIN = -5.0
"""The same of a command within other words, nats: those that are there have 4 and more."""


@dataclass(frozen=True)
class SpottedCommand:
    """A command that may have been said, its score (nats), and where it is in the sound, s."""

    text: str
    score: float
    begin: float
    end: float

    def moved(self, seconds: float) -> SpottedCommand:
        """The same so much later."""
        return replace(self, begin=self.begin + seconds, end=self.end + seconds)


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
        match = ranking.matches[ranking.text]
        return SpottedCommand(ranking.text, ranking.score, *match[1:]) if found else None

    def look(self, sound: Cleaned, sought: str | None) -> SpottedCommand:
        """Find a command in sound that was cleaned of playback.

        That is `sought`, or the likeliest of those that it looks for.
        """
        sounds = self._scorer.phones_over_playback(sound)
        own = [sought] if sought else self._commands
        every = dict.fromkeys([*own, *self._commands, *self._others])
        matches = self._scorer.rank(sounds, list(every)).matches
        text = max(own, key=lambda command: matches[command].score)
        best = matches[text]
        rivals = [match.score for other, match in matches.items() if other not in own]
        score = best.score + min(MAX_LEAD_BONUS, (best.score - max(rivals, default=-math.inf)) / 2)
        return SpottedCommand(text, score, best.begin, best.end)

    def is_within(self, samples: Samples, text: str) -> bool:
        """Whether a command may be somewhere in samples of 16 kHz, among whatever else."""
        sounds = self._scorer.phone_likelihoods(samples)
        nothing = np.zeros(len(sounds.relative))
        ranking = self._scorer.rank(PhoneLikelihoods(sounds.relative, nothing, nothing), [text])
        return ranking.matches[text].score > MIN_SCORE_WITHIN
