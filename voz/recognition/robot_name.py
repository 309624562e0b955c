"""The robot's name: how it is said, and where in a sound."""

from __future__ import annotations

from dataclasses import replace
from typing import NamedTuple

import numpy as np

from voz.audio import SAMPLE_RATE
from voz.errors import CommandsError, ConfigError
from voz.events import NO, YES
from voz.language.generated.language_files import list_sources
from voz.language.pronunciation.lexicon import dictionary_entries
from voz.recognition.accents import spellings, with_british
from voz.recognition.confidence import sigmoid
from voz.recognition.ctc import Floats
from voz.recognition.language import Language
from voz.recognition.name_evidence import find_evidence, read_weights
from voz.recognition.phoneme_network import MOMENT
from voz.recognition.phoneme_scorer import (
    PENALTY_PER_OTHER_PHONE,
    PhoneLikelihoods,
    PhonemeScorer,
)
from voz.settings import Recognition

SETTING = "[recognition] name"

NAME_THRESHOLD = 0.5
"""The confidence that a name needs, 0 to 1."""

NAME_SAMPLES_BEFORE = SAMPLE_RATE
"""A name may begin so long before a segment: a speaker may pause between two words of it."""

GOOD_LOG_ODDS = 3.8
"""A name whose log-odds are usually lower is missed more often."""

COMMANDS_BESIDE_NAME = 1000
"""Commands with which a name is compared; of more, a sample."""

JUST_BEFORE = int(0.4 * SAMPLE_RATE / MOMENT)
PENALTY_JUST_BEFORE = 3.0
"""Nats against a name for each phone in the moments before it: nobody speaks on with it."""

JUST_AFTER = int(0.8 * SAMPLE_RATE / MOMENT)
PENALTY_JUST_AFTER = 1.5
"""Nats against a name alone for each phone in the moments after it: most talk goes on."""


def with_more_words(language: Language, settings: Recognition) -> Language:
    """Add the words of the robot's name, and of answers to what it asks, to a language.

    Raises:
        ConfigError: the language is not English, the search is not for whole commands, nobody
            knows how to say the name, or a command is the same or begins so.
    """
    name = settings.name
    if not settings.more_than_commands:
        return language
    if not language.spoken.is_english:
        raise ConfigError(
            f"`name` and `ask` of [recognition] work in English alone, not {language.spoken.name}"
        )
    if settings.search == "lm":
        raise ConfigError('`name` and `ask` of [recognition] need search = "grammar"')
    if name and (name in language.commands or language.commands.has_continuation(name)):
        raise ConfigError(f'{SETTING}: a command is or begins with "{name}"; give another name')
    from voz.language.command_source import pronounce_words  # builds lists, which most runs do not

    known = spellings(language.dictionary)
    places = {word: SETTING for word in (*name.split(), YES, NO) if word not in known}
    sources = list_sources(language.files)
    try:
        entries = pronounce_words(sources[0].parent if sources else None, places)
    except CommandsError as error:
        raise ConfigError(str(error)) from None
    more = {word: tuple(phones.split()) for word, phones in dictionary_entries(entries)}
    return replace(language, pronunciations={**language.pronunciations, **with_british(more)})


def usual_log_odds(network: PhonemeScorer, name: str) -> float:
    """The log-odds of a name, in the mean, that is said in noise."""
    weights = read_weights()
    return weights.constant + float(weights.typical[network.phone_numbers(name)].sum())


def advice_on_name(language: Language, network: PhonemeScorer, name: str) -> str:
    """Say what would make a name better; empty if it is good."""
    if command := _sounds_like(language, name):
        return f'the name "{name}" sounds like "{command}"; better is one of other sounds'
    if usual_log_odds(network, name) >= GOOD_LOG_ODDS:
        return ""
    longer = f"{name} robot" if name.startswith("hey ") else f"hey {name}"
    return (
        f'the name "{name}" has few sounds, or such as many words have: it is missed more often '
        f'than a longer one; better is "{longer}"'
    )


def _sounds_like(language: Language, name: str) -> str:
    """The command that sounds most like a name; empty if none sounds much like it."""
    from voz.language.similarity.confusion import find_similar
    from voz.language.similarity.similarity_report import WARNING_SIMILARITY

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


class NameMatch(NamedTuple):
    """The log-odds that a name was said where it fits best in a sound, and where that is, s."""

    log_odds: float
    begin: float
    end: float

    @property
    def confidence(self) -> float:
        """How sure it is, 0 to 1."""
        return sigmoid(self.log_odds)


class NameFinder:
    """Finds the robot's name in a sound, whatever is said before and after it."""

    def __init__(self, network: PhonemeScorer, name: str) -> None:
        """Prepare to find a name, the words of which have pronunciations."""
        self._name = network.lattice_of(name)
        self._weights = read_weights()

    def find(
        self, sounds: PhoneLikelihoods, earliest_end: float, alone: bool = False
    ) -> NameMatch | None:
        """Find the name where it fits best; None if it was not said.

        Args:
            sounds: the phones.
            earliest_end: when it ends at the earliest, s.
            alone: whether nothing is said just after it.
        """
        match = self.best(sounds, earliest_end, alone)
        return match if match.confidence >= NAME_THRESHOLD else None

    def best(
        self, sounds: PhoneLikelihoods, earliest_end: float = 0.0, alone: bool = False
    ) -> NameMatch:
        """Find where the name fits best; arguments are those of `find`."""
        before, behind = costs_around(sounds, alone)
        too_early = np.where(np.arange(len(behind)) < _moments(earliest_end), np.inf, 0.0)
        found = find_evidence(sounds.relative, before, behind + too_early, self._name)
        seconds = MOMENT / SAMPLE_RATE
        log_odds = found.log_odds(self._weights)
        return NameMatch(log_odds, found.begin * seconds, found.end * seconds)


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
