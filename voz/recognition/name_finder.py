"""Finds the robot's name in a sound, in doubt by hearing it at several speeds."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from voz.audio import SAMPLE_RATE, Samples
from voz.recognition.confidence import sigmoid
from voz.recognition.ctc import Floats
from voz.recognition.keyphrase import KeyphraseScorer
from voz.recognition.name_evidence import AROUND, find_evidence, read_weights
from voz.recognition.phoneme_network import MOMENT
from voz.recognition.phoneme_scorer import (
    PENALTY_PER_OTHER_PHONE,
    PhoneLikelihoods,
    PhonemeScorer,
    read_phone_symbols,
)

NAME_THRESHOLD = 0.45
"""The confidence that a name needs, 0 to 1."""

NAME_SAMPLES_BEFORE = SAMPLE_RATE
"""A name may begin so long before a segment: a speaker may pause between two words of it."""

SPEEDS = (0.89, 0.93, 0.96, 1.04, 1.08, 1.12)
"""A doubtful name is heard at these speeds, too: which of its phones the network makes out in noise
changes with each. Almost no other word is taken for a name at several of them."""

LEAST_LOG_ODDS = -3.0
"""What has less at its own speed is no name at others either."""

SURE_LOG_ODDS = math.log(1 + len(SPEEDS))
"""With more at one speed, the mean is enough whatever the others are."""

SECONDS_AROUND = 1.0
"""Sound before and after a doubtful name that is heard again, s."""

KEYPHRASE_SPEEDS = (0.93, 1.0, 1.08)
"""Speeds at which pocketsphinx hears a doubtful name."""

KEYPHRASE_MARGIN = 0.4
"""Sound before and after the name that pocketsphinx hears, s."""

USUAL_KEYPHRASE_SCORE = -34.0
"""Of a doubtful name, nats for each phone: a higher one speaks for it, a lower one against it."""

KEYPHRASE_WEIGHT = 0.25
"""Log-odds for each nat."""

MOST_AGAINST = 0.5
"""Log-odds that a low score takes from a name at most: in loud noise all scores are low."""

JUST_BEFORE = int(0.4 * SAMPLE_RATE / MOMENT)
PENALTY_JUST_BEFORE = 3.0
"""Nats against a name for each phone in the moments before it: nobody speaks on with it."""

JUST_AFTER = int(0.8 * SAMPLE_RATE / MOMENT)
PENALTY_JUST_AFTER = 1.5
"""Nats against a name alone for each phone in the moments after it: most talk goes on."""


class NameMatch(NamedTuple):
    """Where a name fits best in a sound.

    Attributes:
        log_odds: that it was said.
        begin: when it begins, s.
        end: when it ends, s.
        against: log-odds that it lost for what is said around it.
    """

    log_odds: float
    begin: float
    end: float
    against: float = 0.0

    @property
    def confidence(self) -> float:
        """How sure it is, 0 to 1."""
        return sigmoid(self.log_odds)


class NameFinder:
    """Finds a name in a sound, whatever is said before and after it."""

    def __init__(self, network: PhonemeScorer, name: str) -> None:
        """Prepare to find a name, the words of which have pronunciations."""
        self._network = network
        self._name = network.lattice_of(name)
        self._weights = read_weights()
        phones = [*read_phone_symbols()]
        self._keyphrase = KeyphraseScorer([phones[n] for n in network.phone_numbers(name)])

    def find(
        self,
        samples: Samples,
        sounds: PhoneLikelihoods,
        earliest_end: float = 0.0,
        alone: bool = False,
    ) -> NameMatch:
        """Find where the name fits best, and how surely it was said.

        In doubt the log-odds are those of the mean of its odds at several speeds, and how well it
        fits by pocketsphinx is added.

        Args:
            samples: the sound, 16 kHz.
            sounds: its phones.
            earliest_end: when it ends at the earliest, s.
            alone: whether nothing is said just after it.
        """
        match = self.best(sounds, earliest_end, alone)
        if not LEAST_LOG_ODDS < match.log_odds < SURE_LOG_ODDS:
            return match
        part, start = _with_margin(samples, match, SECONDS_AROUND)
        earliest_end = max(0.0, earliest_end - start)
        matches = [match]
        for speed in SPEEDS:
            heard = self._network.phone_likelihoods(at_speed(part, speed))
            found = self.best(heard, earliest_end / speed, alone)
            begin, end = (start + speed * place for place in (found.begin, found.end))
            matches.append(NameMatch(found.log_odds, begin, end))
        surest = max(matches, key=lambda match: match.log_odds)
        by_network = mean_odds([match.log_odds for match in matches])
        return surest._replace(log_odds=by_network + self.by_pocketsphinx(samples, match))

    def by_pocketsphinx(self, samples: Samples, match: NameMatch) -> float:
        """The log-odds that pocketsphinx adds to those of a doubtful name.

        0 if the name itself is sure, and the doubt comes from what is said around it.
        """
        if match.log_odds + match.against >= SURE_LOG_ODDS:
            return 0.0
        part, _ = _with_margin(samples, match, KEYPHRASE_MARGIN)
        scores = [self._keyphrase.score(at_speed(part, speed)) for speed in KEYPHRASE_SPEEDS]
        better = sum(scores) / len(scores) - USUAL_KEYPHRASE_SCORE
        return max(KEYPHRASE_WEIGHT * better, -MOST_AGAINST)

    def best(
        self, sounds: PhoneLikelihoods, earliest_end: float = 0.0, alone: bool = False
    ) -> NameMatch:
        """Find where the name fits best by phones alone; arguments are those of `find`."""
        before, behind = costs_around(sounds, alone)
        too_early = np.where(np.arange(len(behind)) < _moments(earliest_end), np.inf, 0.0)
        found = find_evidence(sounds.relative, before, behind + too_early, self._name)
        seconds = MOMENT / SAMPLE_RATE
        log_odds = found.log_odds(self._weights)
        against = AROUND * found.around
        return NameMatch(log_odds, found.begin * seconds, found.end * seconds, against)


def _with_margin(samples: Samples, match: NameMatch, margin: float) -> tuple[Samples, float]:
    """The part of a sound with a name and so much around it, s, and when it begins, s."""
    first = max(0, round((match.begin - margin) * SAMPLE_RATE))
    part = samples[first : round((match.end + margin) * SAMPLE_RATE)]
    return part, first / SAMPLE_RATE


def at_speed(samples: Samples, speed: float) -> Samples:
    """Play samples faster by a factor, and higher by it: as if another had spoken."""
    import soxr  # takes 20 ms, and not every run needs it

    played: Samples = soxr.resample(samples, speed, 1.0)
    return played


def mean_odds(log_odds: Sequence[float]) -> float:
    """The logarithm of the mean of odds, from their logarithms."""
    return float(np.logaddexp.reduce(log_odds)) - math.log(len(log_odds))


def costs_around(sounds: PhoneLikelihoods, alone: bool = False) -> tuple[Floats, Floats]:
    """Nats against a name that begins at each moment, or ends there, for what is said around it."""
    begun = sounds.begin_penalties / PENALTY_PER_OTHER_PHONE
    before = PENALTY_JUST_BEFORE * (begun - _moved(begun, -JUST_BEFORE))
    after = PENALTY_JUST_AFTER * (_moved(begun, JUST_AFTER + 1) - _moved(begun, 1))
    return before, after * alone


def _moved(counted: Floats, moments: int) -> Floats:
    """What is counted so many moments later or earlier; beyond the sound nothing begins."""
    places = np.arange(len(counted)) + moments
    return np.where(places < 0, 0.0, counted[places.clip(0, len(counted) - 1)])


def from_time(sounds: PhoneLikelihoods, seconds: float) -> PhoneLikelihoods:
    """The phones from a time on."""
    end = _moments(seconds)
    return PhoneLikelihoods(
        sounds.relative[end:],
        sounds.begin_penalties[end:] - sounds.begin_penalties[end : end + 1],
        sounds.end_penalties[end:],
    )


def _moments(seconds: float) -> int:
    return round(seconds * SAMPLE_RATE / MOMENT)
