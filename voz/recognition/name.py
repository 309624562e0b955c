"""The robot's name: where it is in a sound, and how surely it was said.

A logistic regression over what the network hears while each phone of the name is said, and over how
long that lasts. A phone that is often taken for another, as TH for F, counts little against a name
if it is; one for which talk is seldom taken counts much for it. `training/name_weights.py` fits the
weights, by words that voices say, and by what comes nearest to other words in talk. A name in doubt
is heard at several speeds, and by pocketsphinx.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from functools import cache
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from voz.audio import SAMPLE_RATE, Samples
from voz.language.sentences.text_lines import PRONUNCIATIONS_FILE
from voz.language.similarity import find_similar
from voz.language.similarity_report import WARNING_SIMILARITY
from voz.recognition.confidence import sigmoid
from voz.recognition.language import Language, spellings
from voz.recognition.network.ctc import NOWHERE, Floats, Lattice, Places, best_path
from voz.recognition.network.phoneme_network import MOMENT
from voz.recognition.network.score import (
    PENALTY_PER_OTHER_PHONE,
    PhoneLikelihoods,
    PhonemeScorer,
)
from voz.recognition.network.symbols import read_phone_symbols
from voz.recognition.pocketsphinx.decoder import KeyphraseScorer
from voz.recognition.thresholds import NAME_THRESHOLD

WEIGHTS_FILE = Path(__file__).with_name("name_weights.npz")

LEAST_LIKELY = -9.2
"""Floor of the relative log-likelihood of a phone, nats; `heard` is centered on half of it."""

LENGTH_LIMITS = np.array([2, 3, 4, 5, 7, 9, 12, 16, 25])
"""Moments that separate the classes of how long it takes until the next phone."""

MOST_BEFORE, MOST_AFTER = 1, 2
"""Moments around a phone in which the network may hear another in its place."""

CONTEXT_WEIGHT = 0.8
"""Log-odds against a name for each nat that is against what is said around it. Fitted like the
others it is 0.5, but then a name that is said clearly in talk that goes on wakes the robot.
"""


class NameWeights(NamedTuple):
    """The weights of the regression."""

    constant: float  # log-odds of a name without phones
    fit: float  # log-odds for each nat of `fit` in the evidence
    # Log-odds for each nat of `heard` in the evidence, phones of the name x what is heard: each
    # phone, and last a blank.
    heard: Floats
    lengths: Floats  # log-odds for each class of length, phones of the name x classes
    typical: Floats  # log-odds for each phone of a name that is said in noise, in the mean


class NameEvidence(NamedTuple):
    """Where a name fits best, and what is heard there."""

    fit: float  # relative log-likelihood of the name, nats; infinitely low if it fits nowhere
    around: float  # what is said around it costs, nats
    begin: int  # its first moment
    end: int  # the moment after its last
    phones: Places  # the number of each of its phones
    # Relative log-likelihood of each phone, and of a blank, while each phone is said, nats; phones
    # of the name x (phones of the dictionary + 1).
    heard: Floats
    lengths: Places  # the class of length of each of its phones

    def log_odds(self, weights: NameWeights) -> float:
        """The log-odds that the name was said."""
        heard = float((weights.heard[self.phones] * self.heard).sum())
        lengths = float(weights.lengths[self.phones, self.lengths].sum())
        whole = weights.constant + weights.fit * self.fit - CONTEXT_WEIGHT * self.around
        return whole + heard + lengths


@cache
def read_weights(file: Path = WEIGHTS_FILE) -> NameWeights:
    """Read the weights."""
    with np.load(file) as arrays:
        constant, fit = arrays["constant"].item(), arrays["fit"].item()
        return NameWeights(constant, fit, arrays["heard"], arrays["lengths"], arrays["typical"])


def write_weights(weights: NameWeights, file: Path) -> None:
    """Write the weights."""
    arrays: dict[str, Any] = {name: np.float32(v) for name, v in weights._asdict().items()}
    np.savez(file, **arrays)


def find_evidence(
    log_ratios: Floats, before: Floats, behind: Floats, name: Lattice
) -> NameEvidence:
    """Find where a name fits best, and what is heard there.

    `log_ratios` are log-probabilities less that of the likeliest symbol, nats, moments x (phones of
    the dictionary and a blank); `before` and `behind` the costs of beginning and ending at each
    moment, nats.
    """
    path = best_path(log_ratios, before, behind, name)
    nodes = np.array(path.nodes, np.intp)
    symbols = name.symbols[nodes]
    is_phone = symbols != log_ratios.shape[1] - 1
    begins = np.flatnonzero(is_phone & (np.diff(nodes, prepend=NOWHERE) != 0))
    ends = np.flatnonzero(is_phone & (np.diff(nodes, append=NOWHERE) != 0))
    firsts, lasts = path.begin + begins, path.begin + ends
    nexts = np.append(firsts[1:], lasts[-1:] + MOST_AFTER + 1)
    end = path.begin + len(nodes)
    around = float(before[path.begin] + behind[end - 1]) if path.nodes else 0.0
    return NameEvidence(
        path.score + around,
        around,
        path.begin,
        end,
        symbols[begins],
        _heard(log_ratios, firsts - MOST_BEFORE, np.minimum(nexts, lasts + 1 + MOST_AFTER)),
        np.searchsorted(LENGTH_LIMITS, nexts - firsts),
    )


def _heard(log_ratios: Floats, begins: Places, ends: Places) -> Floats:
    """How likely each phone is at most in each of some stretches, and a blank at least."""
    heard = np.empty((len(begins), log_ratios.shape[1]))
    for number, (begin, end) in enumerate(zip(begins, ends, strict=True)):
        stretch = log_ratios[max(0, begin) : end]
        heard[number, :-1] = stretch[:, :-1].max(axis=0)
        heard[number, -1] = stretch[:, -1].min()
    return np.maximum(heard, LEAST_LIKELY) - LEAST_LIKELY / 2


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

SETTLED_LOG_ODDS = SURE_LOG_ODDS + MOST_AGAINST + math.log(NAME_THRESHOLD / (1 - NAME_THRESHOLD))
"""With more at any speed the name was said, whatever it has at others and by pocketsphinx, and
these are not asked: that takes longer than a microphone waits on a slow computer."""

JUST_BEFORE = int(0.4 * SAMPLE_RATE / MOMENT)
PENALTY_JUST_BEFORE = 3.0
"""Nats against a name for each phone in the moments before it: nobody speaks on with it."""

JUST_AFTER = int(0.8 * SAMPLE_RATE / MOMENT)
PENALTY_JUST_AFTER = 1.5
"""Nats against a name alone for each phone in the moments after it: most talk goes on."""

LONGEST_PHONE = int(0.15 * SAMPLE_RATE / MOMENT)
"""Moments for each phone, in the mean, of a name within which nobody pauses."""

MIN_LEAD_OF_LONG = 1.5
"""Log-odds by which a name that takes longer must be ahead of one that does not. If it is not, its
last phones were found in the command behind it, which would lose the words before them."""


class NameMatch(NamedTuple):
    """Where a name fits best in a sound."""

    log_odds: float  # that it was said
    begin: float  # when it begins, s
    end: float  # when it ends, s
    against: float = 0.0  # log-odds that it lost for what is said around it

    @property
    def confidence(self) -> float:
        """How sure it is, 0 to 1."""
        return sigmoid(self.log_odds)


class NameFinder:
    """Finds a name in a sound, whatever is said before and after it."""

    def __init__(self, network: PhonemeScorer, name: str) -> None:
        """Prepare to find a name, the words of which have pronunciations."""
        self._network = network
        phones = [*read_phone_symbols()]
        said = network.lattice_of(name)
        self._name = said._replace(symbols=np.minimum(said.symbols, len(phones)))
        self._weights = read_weights()
        self._keyphrase = KeyphraseScorer([phones[n] for n in network.phone_numbers(name)])

    def find(
        self,
        samples: Samples,
        likelihoods: PhoneLikelihoods,
        earliest_end: float = 0.0,
        alone: bool = False,
    ) -> NameMatch:
        """Find where the name fits best, and how surely it was said; samples of 16 kHz.

        In doubt the log-odds are those of the mean of its odds at several speeds, and how well it
        fits by pocketsphinx is added; where one speed settles it, they are at least that. It ends
        at `earliest_end`, s, or later; `alone` says that nothing is said just after it.
        """
        match = self.best(likelihoods, earliest_end, alone)
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
            if surest.log_odds >= SETTLED_LOG_ODDS:
                return surest._replace(log_odds=surest.log_odds - SURE_LOG_ODDS)
        by_network = mean_odds([match.log_odds for match in matches])
        return surest._replace(log_odds=by_network + self.by_pocketsphinx(samples, match))

    def find_alone(
        self,
        samples: Samples,
        likelihoods: PhoneLikelihoods,
        earliest_end: float,
        found: NameMatch,
        found_from: float,
    ) -> NameMatch:
        """Find the name with nothing said just after it, knowing what `find` has found.

        Where that has nothing behind it, it is not looked for again: a doubtful name takes long.
        `found_from` was its earliest end.
        """
        alone = self.best(likelihoods, earliest_end, alone=True)
        if alone == self.best(likelihoods, found_from):
            return found
        return self.find(samples, likelihoods, earliest_end, alone=True)

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
        self, likelihoods: PhoneLikelihoods, earliest_end: float = 0.0, alone: bool = False
    ) -> NameMatch:
        """Find where the name fits best by phones alone; arguments are those of `find`."""
        before, behind = costs_around(likelihoods, alone)
        too_early = np.where(np.arange(len(behind)) < _moments(earliest_end), np.inf, 0.0)
        log_ratios = english_phones(likelihoods.log_ratios)
        ends = behind + too_early
        found = find_evidence(log_ratios, before, ends, self._name)
        log_odds, place = found.log_odds(self._weights), found
        longest = found.begin + LONGEST_PHONE * len(found.phones)
        if _moments(earliest_end) < longest < found.end:
            heard = log_ratios[:longest], before[:longest], ends[:longest]
            short = find_evidence(*heard, self._name)
            place = short if short.log_odds(self._weights) > log_odds - MIN_LEAD_OF_LONG else found
        seconds = MOMENT / SAMPLE_RATE
        against = CONTEXT_WEIGHT * found.around
        return NameMatch(log_odds, place.begin * seconds, place.end * seconds, against)


def english_phones(log_ratios: Floats) -> Floats:
    """Leave out the phones of other languages, for which no weights of names were fitted."""
    english: Floats = np.delete(log_ratios, np.s_[len(read_phone_symbols()) : -1], axis=1)
    return english


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


def costs_around(likelihoods: PhoneLikelihoods, alone: bool = False) -> tuple[Floats, Floats]:
    """Nats against a name that begins at each moment, or ends there, for what is said around it."""
    begun = likelihoods.begin_penalties / PENALTY_PER_OTHER_PHONE
    before = PENALTY_JUST_BEFORE * (begun - _moved(begun, -JUST_BEFORE))
    after = PENALTY_JUST_AFTER * (_moved(begun, JUST_AFTER + 1) - _moved(begun, 1))
    return before, after * alone


def _moved(counted: Floats, moments: int) -> Floats:
    """What is counted so many moments later or earlier; beyond the sound nothing begins."""
    places = np.arange(len(counted)) + moments
    return np.where(places < 0, 0.0, counted[places.clip(0, len(counted) - 1)])


def from_time(likelihoods: PhoneLikelihoods, seconds: float) -> PhoneLikelihoods:
    """The phones from a time on."""
    end = _moments(seconds)
    return PhoneLikelihoods(
        likelihoods.log_ratios[end:],
        likelihoods.begin_penalties[end:] - likelihoods.begin_penalties[end : end + 1],
        likelihoods.end_penalties[end:],
    )


def _moments(seconds: float) -> int:
    return round(seconds * SAMPLE_RATE / MOMENT)


GOOD_LOG_ODDS = 3.8
"""A name whose log-odds are usually lower is missed more often."""

COMMANDS_BESIDE_NAME = 1000
"""Commands with which a name is compared; of more, a sample."""


def usual_log_odds(network: PhonemeScorer, name: str) -> float:
    """The log-odds of a name, in the mean, that is said in noise."""
    weights = read_weights()
    return weights.constant + float(weights.typical[network.phone_numbers(name)].sum())


def advice_on_name(language: Language, network: PhonemeScorer, name: str) -> str:
    """Say what would make a name better; empty if it is good."""
    if command := _sounds_like(language, name):
        return f'the name "{name}" sounds like "{command}"; better is one of other sounds'
    for word in name.split():
        if word in language.guessed:
            guess = " ".join(language.pronunciations[word])
            return (
                f'no dictionary has "{word}" of the name "{name}", and {guess} is a guess: '
                f"correct it in {PRONUNCIATIONS_FILE} beside the command list"
            )
    if usual_log_odds(network, name) >= GOOD_LOG_ODDS:
        return ""
    longer = f"{name} robot" if name.startswith("hey ") else f"hey {name}"
    return (
        f'the name "{name}" has few sounds, or such as many words have: it is missed more often '
        f'than a longer one; better is "{longer}"'
    )


def _sounds_like(language: Language, name: str) -> str:
    """The command that sounds most like a name; empty if none sounds much like it."""
    said = {
        word: [" ".join(phones) for phones in ways]
        for word, ways in spellings(language.pronunciations).items()
    }
    pairs = [
        pair
        for command in language.commands.sample(COMMANDS_BESIDE_NAME)
        for pair in find_similar((command, name), said, at_least=WARNING_SIMILARITY)
    ]
    return max(pairs, key=lambda pair: pair.similarity).first if pairs else ""
