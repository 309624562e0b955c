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
from voz.errors import ConfigError
from voz.language.files import LanguageFiles
from voz.recognition.accents import spellings
from voz.recognition.ctc import Floats, Lattice, lattice, log_likelihoods
from voz.recognition.language import Language, load_language
from voz.recognition.network_file import DEFAULT_NETWORK, UnknownNetworkError
from voz.recognition.phoneme_network import BLANKS, PhonemeNetwork

IPA = Path(__file__).with_name("ipa.tsv")
"""The symbols that each phone of the dictionary may sound like; their probabilities add up."""

READINGS = Path(__file__).with_name("readings.tsv")
"""Words that the network writes unlike any dictionary, as it learned some by heart.

`python benchmarks/readings.py` measures and writes them.
"""

LEAST = 1e-10
"""A probability; the network is never surer than that of what it does not hear."""

LISTS = 4
"""Lists of commands that are laid out; most often it is asked about one of the last."""

MOST_WAYS = 8
"""Pronunciations of a command of which the best counts.

All together count for one that has more: eight words that may each be said in three ways have
thousands, most of them nearly as good as the best.
"""


class Pronunciation(NamedTuple):
    """One way to say a word.

    Attributes:
        symbols: numbers of what the network hears.
        phones: how many phones the word has; a reading counts as the dictionary's phones do.
    """

    symbols: Sequence[int]
    phones: int


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

    def __init__(
        self,
        spellings: Mapping[str, Iterable[Sequence[str]]],
        readings: Mapping[str, Sequence[str]] | None = None,
        network: str | None = None,
    ) -> None:
        """Load the network.

        Args:
            spellings: the phones of each word, in all the ways that it may be said.
            readings: the symbols that the network writes for words that it learned by heart; those
                that were measured with the network that comes with voz, if it is None.
            network: a file of weights in place of the one that comes with voz.

        Raises:
            ConfigError: the file cannot be used.
            UnknownNetworkError: the network is of no use for these words.
        """
        self._network = load_network(network)
        known = {word: list(ways) for word, ways in spellings.items()}
        sounds = read_sounds()
        unknown = {p for ways in known.values() for way in ways for p in way} - {*sounds}
        if unknown:
            raise UnknownNetworkError(f"it knows no phone {' or '.join(sorted(unknown))}")
        if readings is None:
            readings = {} if network else read_readings()
        own = {word: way for word, way in readings.items() if word in known}
        sounds |= {symbol: [symbol] for way in own.values() for symbol in way}
        numbers = {sound: number for number, sound in enumerate(sounds)}
        self._pronunciations = {
            word: _pronunciations(ways, own.get(word), numbers) for word, ways in known.items()
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
        said = [(command, sum(ways[0].phones for ways in words)) for command, words in lines]
        symbols = [[[way.symbols for way in ways] for ways in words] for _, words in lines]
        return said, lattice(symbols, self._blank)

    def _ways(self, command: str) -> Iterable[Sequence[Sequence[Pronunciation]]]:
        """Tell the ways of its words: each of its pronunciations alone, or all of them at once."""
        words = [self._pronunciations[word] for word in command.split()]
        if prod(map(len, words)) > MOST_WAYS:
            return [words]
        return ([[way] for way in ways] for ways in product(*words))


def load_network(file: str | None = None) -> PhonemeNetwork:
    """Load a network.

    Args:
        file: of its weights; without one, those that come with voz.

    Raises:
        ConfigError: the file cannot be used.
    """
    try:
        return PhonemeNetwork(Path(file or DEFAULT_NETWORK))
    except UnknownNetworkError as error:
        advice = "name a file of weights that `training/teach.py` made"
        raise ConfigError(f"{error}; {advice}") from None


def second_ear_for(language: Language, network: str | None = None) -> SecondEar:
    """Load the second ear for the words of a language; the rest is as with `SecondEar`.

    Phones of another language may be called like English ones, and be other sounds.
    """
    if not language.spoken.is_english:
        raise UnknownNetworkError(f"it knows English alone, and this is {language.spoken.name}")
    return SecondEar(spellings(language.pronunciations), network=network)


def why_missing(files: LanguageFiles, network: str | None = None) -> str | None:
    """Say why there is no second ear for a language; None if there is one.

    Raises:
        VozError: the language files, or the file of the network, cannot be used.
    """
    try:
        second_ear_for(load_language(files), network)
    except UnknownNetworkError as error:
        return str(error)
    return None


def read_readings() -> dict[str, list[str]]:
    """Read which symbols the network writes for the words that it learned by heart."""
    lines = READINGS.read_text(encoding="utf-8").splitlines()
    fields = (line.split("\t") for line in lines if not line.startswith("#"))
    return {word: reading.split() for word, reading, *_ in fields}


def _pronunciations(
    ways: Sequence[Sequence[str]], reading: Sequence[str] | None, numbers: Mapping[str, int]
) -> list[Pronunciation]:
    """Number the ways to say a word, the network's own reading last."""
    said = [Pronunciation([numbers[phone] for phone in way], len(way)) for way in ways]
    if reading:
        symbols = [numbers[symbol] for symbol in reading]
        said.append(Pronunciation(symbols, min(map(len, ways))))
    return said


def read_sounds() -> dict[str, list[str]]:
    """Read the symbols that each phone of the dictionary may sound like."""
    lines = IPA.read_text(encoding="utf-8").splitlines()
    return {phone: sounds.split() for phone, _, sounds in (line.partition("\t") for line in lines)}


def _merged(symbols: Sequence[str], sounds: Collection[Sequence[str]]) -> Floats:
    """A matrix that adds the probabilities of a phone's symbols, and last those of the blanks."""
    merged = np.zeros((len(symbols), len(sounds) + 1))
    for number, alike in enumerate(sounds):
        merged[[symbols.index(symbol) for symbol in alike], number] = 1
    merged[-BLANKS:, -1] = 1
    return merged
