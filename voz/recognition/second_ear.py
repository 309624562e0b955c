"""A second opinion on which command was said, by a network that knows no words."""

from __future__ import annotations

from collections.abc import Collection, Iterable, Mapping, Sequence
from functools import lru_cache
from itertools import product
from math import prod
from pathlib import Path
from typing import NamedTuple

import numpy as np

from voz.audio import Samples
from voz.language.files import LanguageFiles
from voz.recognition.accents import spellings
from voz.recognition.ctc import Floats, Lattice, Ways, lattice, log_likelihoods
from voz.recognition.hama_weights import UnknownNetworkError
from voz.recognition.language import Language, load_language
from voz.recognition.phoneme_engine import load_network
from voz.recognition.phoneme_network import BLANKS

IPA = Path(__file__).with_name("ipa.tsv")
"""The symbols that each phone of the dictionary may sound like; their probabilities add up."""

LEAST = 1e-10
"""A probability; the network is never surer than that of what it does not hear."""

LISTS = 4
"""Lists of commands that are laid out; most often it is asked about one of the last."""

MOST_WAYS = 8
"""Pronunciations of a command of which the best counts.

All together count for one that has more: eight words that may each be said in three ways have
thousands, most of them nearly as good as the best.
"""


class Fit(NamedTuple):
    """How a command fits what was heard.

    Attributes:
        score: its log-likelihood, nats.
        phones: how many it has.
    """

    score: float
    phones: int


class Opinion(NamedTuple):
    """What the second ear thinks of some commands.

    Attributes:
        fits: of each command.
        best: the log-likelihood of whatever it hears, nats; no command is much better.
    """

    fits: Mapping[str, Fit]
    best: float

    def fit(self, command: str) -> float:
        """How well a command explains what is heard, nats for each phone; about 0 is perfect."""
        score, phones = self.fits[command]
        return (score - self.best) / phones

    def margin(self, command: str) -> float:
        """How much better a command fits than any other, nats for each phone of it."""
        score, phones = self.fits[command]
        others = (fit.score for other, fit in self.fits.items() if other != command)
        return (score - max(others, default=-np.inf)) / phones


class SecondEar:
    """Knows how the words of a language are pronounced; made once, used for many."""

    def __init__(self, spellings: Mapping[str, Iterable[Sequence[str]]]) -> None:
        """Load the network.

        Args:
            spellings: the phones of each word, in all the ways that it may be said.

        Raises:
            UnknownNetworkError: the network is not there, or is of no use for these words.
        """
        self._network = load_network()
        known = {word: list(ways) for word, ways in spellings.items()}
        sounds = _read_sounds()
        unknown = {p for ways in known.values() for way in ways for p in way} - {*sounds}
        if unknown:
            raise UnknownNetworkError(f"it knows no phone {' or '.join(sorted(unknown))}")
        numbers = {phone: number for number, phone in enumerate(sounds)}
        self._numbered: dict[str, Ways] = {
            word: [[numbers[phone] for phone in way] for way in ways]
            for word, ways in known.items()
        }
        self._blank = len(sounds)
        self._merged = _merged(self._network.symbols, sounds.values())
        self._laid_out = lru_cache(LISTS)(self._lay_out)

    def opinion(self, samples: Samples, commands: Collection[str]) -> Opinion:
        """Tell how commands fit.

        Args:
            samples: an utterance, 16 kHz, as it was heard.
            commands: at least one; their words have pronunciations.
        """
        heard = np.exp(self._network.log_probabilities(samples))
        blank = heard[:, -BLANKS:].sum(axis=1)
        best = np.maximum(heard[:, :-BLANKS].max(axis=1), blank)
        probabilities = np.maximum(heard.astype(np.float64) @ self._merged, LEAST)
        said, sentences = self._laid_out(tuple(commands))
        fits: dict[str, Fit] = {}
        scores = log_likelihoods(probabilities, sentences)
        for (command, phones), score in zip(said, scores, strict=True):
            if command not in fits or score > fits[command].score:
                fits[command] = Fit(float(score), phones)
        return Opinion(fits, float(np.log(best).sum()))

    def _lay_out(self, commands: tuple[str, ...]) -> tuple[list[tuple[str, int]], Lattice]:
        """Lay out the commands, and tell of each line whose it is, and how many phones it has."""
        lines = [(command, words) for command in commands for words in self._ways(command)]
        said = [(command, sum(len(ways[0]) for ways in words)) for command, words in lines]
        return said, lattice([words for _, words in lines], self._blank)

    def _ways(self, command: str) -> Iterable[Sequence[Ways]]:
        """Tell the ways of its words: each of its pronunciations alone, or all of them at once."""
        words = [self._numbered[word] for word in command.split()]
        if prod(map(len, words)) > MOST_WAYS:
            return [words]
        return ([[way] for way in ways] for ways in product(*words))


def second_ear_for(language: Language) -> SecondEar:
    """Load the second ear for the words of a language; errors are those of `SecondEar`.

    Phones of another language may be called like English ones, and be other sounds.
    """
    if not language.spoken.is_english:
        raise UnknownNetworkError(f"it knows English alone, and this is {language.spoken.name}")
    return SecondEar(spellings(language.pronunciations))


def why_missing(files: LanguageFiles) -> str | None:
    """Tell why there is no second ear for a language; None if there is one."""
    try:
        second_ear_for(load_language(files))
    except UnknownNetworkError as error:
        return str(error)
    return None


def _read_sounds() -> dict[str, list[str]]:
    lines = IPA.read_text(encoding="utf-8").splitlines()
    return {phone: sounds.split() for phone, _, sounds in (line.partition("\t") for line in lines)}


def _merged(symbols: Sequence[str], sounds: Collection[Sequence[str]]) -> Floats:
    """A matrix that adds the probabilities of a phone's symbols, and last those of the blanks."""
    merged = np.zeros((len(symbols), len(sounds) + 1))
    for number, alike in enumerate(sounds):
        merged[[symbols.index(symbol) for symbol in alike], number] = 1
    merged[-BLANKS:, -1] = 1
    return merged
