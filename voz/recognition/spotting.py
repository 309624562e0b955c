"""Keyword spotting: whether a command that stops was said just now, amid any sound.

While the robot speaks, in sound that is cleaned of its echo.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Collection, Iterable
from dataclasses import dataclass, replace

import numpy as np
import numpy.typing as npt

from voz.audio import SAMPLE_RATE, Samples
from voz.audio.echo import Cleaned
from voz.audio.segment import MAX_WORD_SECONDS
from voz.audio.sound_files import to_int16
from voz.events import Utterance
from voz.process.call_lock import NonReentrantLock
from voz.recognition.network.score import MAX_LEAD_BONUS, PhoneLikelihoods, PhonemeScorer
from voz.recognition.thresholds import (
    MIN_PLAYBACK_SCORES,
    MIN_SCORE_WITHIN,
    MIN_SPOTTING_SCORE,
    STOP_LIMITS,
    PlaybackLimits,
)


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
        self,
        scorer: PhonemeScorer,
        commands: Collection[str],
        others: Iterable[str],
        lock: NonReentrantLock,
    ) -> None:
        """Prepare to look for one command or more, which may be taken for `others`.

        Each search takes the lock, which is that of the recognizer.
        """
        self._scorer = scorer
        self._lock = lock
        self._commands = commands
        self._others = [other for other in others if other not in commands]
        most_words = max(len(command.split()) for command in commands)
        self._window = int(MAX_WORD_SECONDS * SAMPLE_RATE) * most_words

    def spot(self, so_far: Samples) -> SpottedCommand | None:
        """Find a command in the latest sound, 16 kHz."""
        with self._lock:
            likelihoods = self._scorer.phone_likelihoods(so_far[-self._window :])
            ranking = self._scorer.rank(likelihoods, [*self._commands, *self._others])
        found = ranking.text in self._commands and ranking.score > MIN_SPOTTING_SCORE
        match = ranking.matches[ranking.text]
        return SpottedCommand(ranking.text, ranking.score, *match[1:]) if found else None

    def spot_over_playback(self, sound: Cleaned, sought: str | None = None) -> SpottedCommand:
        """Find a command in sound that was cleaned of playback.

        That is `sought`, or the likeliest of those that it looks for.
        """
        own = [sought] if sought else self._commands
        every = dict.fromkeys([*own, *self._commands, *self._others])
        with self._lock:
            matches = self._scorer.rank(self._scorer.phones_over_playback(sound), [*every]).matches
        text = max(own, key=lambda command: matches[command].score)
        best = matches[text]
        rivals = [match.score for other, match in matches.items() if other not in own]
        score = best.score + min(MAX_LEAD_BONUS, (best.score - max(rivals, default=-math.inf)) / 2)
        return SpottedCommand(text, score, best.begin, best.end)

    def is_within(self, samples: Samples, text: str) -> bool:
        """Whether a command may be somewhere in samples of 16 kHz, among whatever else."""
        with self._lock:
            log_ratios = self._scorer.phone_likelihoods(samples).log_ratios
            nothing = np.zeros(len(log_ratios))
            anywhere = PhoneLikelihoods(log_ratios, nothing, nothing)
            match = self._scorer.rank(anywhere, [text]).matches[text]
        return match.score > MIN_SCORE_WITHIN


WINDOW_SECONDS = 1.4
"""Length of a window; windows overlap so that several hold the whole word."""

PLAYBACK_WINDOW = int(WINDOW_SECONDS * SAMPLE_RATE)

WINDOWS = 4
"""A command must be found in some of this many windows."""

SAME_END = 0.1
"""Two windows have the same word if its ends are closer than this, s."""

MARGIN = 0.25
"""Sound around a command that is listened to as well, s."""


class PlaybackSpotter:
    """Checks window after window of one stream; a command counts if several of them have it.

    What is left of the robot's words changes with each window in which they are fitted; what
    somebody says stays.
    """

    def __init__(
        self,
        spotter: KeywordSpotter | None,
        utterance_of: Callable[[SpottedCommand, float], Utterance],
    ) -> None:
        """Start a stream; without the network there is no spotter.

        `utterance_of` makes the event of a command, and the time of its decision, s.
        """
        self._spotter = spotter
        self._utterance_of = utterance_of
        self._found: list[SpottedCommand] = []  # in the last windows, in the time of the stream

    @property
    def works(self) -> bool:
        """Whether there is a network, by which it finds commands."""
        return self._spotter is not None

    def check(self, sound: Cleaned, now: float) -> Utterance | None:
        """Return a command that must not be missed, if it was said.

        The sound is the last `PLAYBACK_WINDOW` samples, which end at a time of the stream, s.
        """
        if self._spotter is None:
            return None
        found = self._spotter.spot_over_playback(sound)
        if sound.level_above_residue(found.begin, found.end) < STOP_LIMITS.level:
            return None
        found = found.moved(now - len(sound.samples) / SAMPLE_RATE)
        before = [other for other in self._found if other.end > now - WINDOW_SECONDS]
        self._found = [*before, found][-WINDOWS:]
        alike = [
            other.score
            for other in before
            if other.text == found.text and abs(other.end - found.end) < SAME_END
        ]
        if not _is_enough(found.score, sorted(alike, reverse=True)):
            return None
        self._found = []
        return self._utterance_of(found, now)

    def is_said(
        self, text: str, sound: Cleaned, begin: float, end: float, limits: PlaybackLimits
    ) -> bool:
        """Whether a command is no echo: it stands out of the echo, and has phones of its own.

        It begins and ends at times in the sound, s, which has as much as there is around it.
        """
        first = begin - MARGIN
        if begin < 0 or first * SAMPLE_RATE > len(sound.samples):
            return False
        if self._spotter is None:
            return True
        first = max(0.0, first)
        part = sound.cut(slice(round(first * SAMPLE_RATE), round((end + MARGIN) * SAMPLE_RATE)))
        found = self._spotter.spot_over_playback(part, text)
        level = sound.level_above_residue(first + found.begin, first + found.end)
        return found.score > limits.score and level > limits.level

    def may_be_echo(self, text: str, played: npt.NDArray[np.float32]) -> bool:
        """Whether a command may be among the words of what was played, 16 kHz, -1 to 1."""
        return self._spotter is not None and self._spotter.is_within(to_int16(played), text)


def _is_enough(score: float, others: list[float]) -> bool:
    means = {
        count: (score + sum(others[: count - 1])) / count
        for count in MIN_PLAYBACK_SCORES
        if len(others) >= count - 1
    }
    return any(mean > MIN_PLAYBACK_SCORES[count] for count, mean in means.items())
