"""How well commands fit a stretch of sound, by a network that knows phones and no words.

The score of a command is evidence in nats that adds up over its phones, as long as it is said
somewhere in the stretch: a long command may be said badly and is still told from all else, a short
one has to be said well.
"""

from __future__ import annotations

from collections.abc import Collection, Iterable, Mapping, Sequence
from functools import cached_property, lru_cache
from pathlib import Path
from typing import NamedTuple

import numpy as np

from voz.audio import SAMPLE_RATE, Samples
from voz.errors import ConfigError
from voz.language.generated.language_files import LanguageFiles
from voz.recognition.accents import spellings
from voz.recognition.ctc import Floats, Lattice, best_matches, lattice
from voz.recognition.language import Language, load_language
from voz.recognition.network_file import DEFAULT_NETWORK, UnknownNetworkError
from voz.recognition.phoneme_network import BLANKS, MOMENT, PhonemeNetwork

IPA = Path(__file__).with_name("ipa.tsv")
"""The symbols that each phone of the dictionary may sound like; their probabilities add up."""

LEAST = 1e-10
"""A probability; the network is never surer than that of what it does not hear."""

LISTS = 4
"""Lists of commands that are laid out; most often it is asked about one of the last."""

PHONE = 2.0
"""Nats that each phone of a command speaks for it, if it fits as well as the likeliest symbols."""

LEAST_REWARD = 7.0
"""Nats that a command of few phones, as `up` or `no`, has at least: what `PHONE` gives it is never
enough. With 8 more than 2 in 100 other words by people are taken for one."""

OTHER_PHONE = 2.5
"""Nats against a command for each phone that is heard before or behind it; 4 are as good."""

PROPOSED = 1.0
"""Nats for the command that pocketsphinx finds, too."""

MOST_MARGIN = 6.0
"""Nats for a command that no other one comes near to."""


class Match(NamedTuple):
    """Where a command fits best.

    Attributes:
        score: the evidence for it, nats, whatever the other commands are.
        begin: where it begins in the samples, s.
        end: where it ends there, s.
    """

    score: float
    begin: float
    end: float


class PhoneLikelihoods(NamedTuple):
    """The phones in a stretch of sound.

    Attributes:
        relative: moments x phones, log-probabilities less that of the likeliest symbol, nats.
        before: the nats against a command that begins at each moment.
        behind: the nats against one that ends there.
    """

    relative: Floats
    before: Floats
    behind: Floats


class Ranking:
    """What the network makes of some commands.

    Attributes:
        matches: where each of them fits best.
    """

    def __init__(self, matches: Mapping[str, Match]) -> None:
        self.matches = matches

    @cached_property
    def text(self) -> str:
        """The command that fits best."""
        return max(self.matches, key=lambda command: self.matches[command].score)

    @cached_property
    def next_best(self) -> str:
        """The command that fits next best; empty if there is no other."""
        others = (command for command in self.matches if command != self.text)
        return max(others, key=lambda command: self.matches[command].score, default="")

    @cached_property
    def score(self) -> float:
        """The evidence for the best command in nats, with how far it is ahead of the next one."""
        best = self.matches[self.text].score
        if not self.next_best:
            return best + MOST_MARGIN
        return best + min(MOST_MARGIN, (best - self.matches[self.next_best].score) / 2)


class PhonemeScorer:
    """Knows how the words of a language are pronounced; made once, used for many."""

    def __init__(
        self, spellings: Mapping[str, Iterable[Sequence[str]]], network: str | None = None
    ) -> None:
        """Load the network.

        Args:
            spellings: the phones of each word, in all the ways that it may be said.
            network: a file of weights in place of the one that comes with voz.

        Raises:
            ConfigError: the file cannot be used.
            UnknownNetworkError: the network is of no use for these words.
        """
        self._network = load_network(network)
        known = {word: list(ways) for word, ways in spellings.items()}
        sounds = read_phone_symbols()
        unknown = {p for ways in known.values() for way in ways for p in way} - {*sounds}
        if unknown:
            raise UnknownNetworkError(f"it knows no phone {' or '.join(sorted(unknown))}")
        numbers = {sound: number for number, sound in enumerate(sounds)}
        self._pronunciations = {
            word: [[numbers[phone] for phone in way] for way in ways]
            for word, ways in known.items()
        }
        self._blank = len(sounds)
        self._merged = _merged(self._network.symbols, sounds.values())
        self._laid_out = lru_cache(LISTS)(self._lay_out)

    def phone_likelihoods(self, samples: Samples) -> PhoneLikelihoods:
        """Find the phones in a stretch of sound, 16 kHz, as it was heard."""
        heard = np.exp(self._network.log_probabilities(samples)).astype(np.float64)
        blank = heard[:, -BLANKS:].sum(axis=1)
        likeliest = heard[:, :-BLANKS].max(axis=1)
        phones = np.where(blank < likeliest, heard[:, :-BLANKS].argmax(axis=1), -1)
        begun = np.cumsum((phones >= 0) & (phones != np.concatenate([[-1], phones[:-1]])))
        probabilities = np.maximum(heard @ self._merged, LEAST)
        return PhoneLikelihoods(
            np.log(probabilities / np.maximum(likeliest, blank)[:, np.newaxis]),
            OTHER_PHONE * np.concatenate([[0], begun[:-1]]),
            OTHER_PHONE * (begun[-1] - begun),
        )

    def rank(
        self, sounds: PhoneLikelihoods, commands: Collection[str], proposed: str = ""
    ) -> Ranking:
        """Tell how commands fit.

        Args:
            sounds: what was heard.
            commands: at least one; their words have pronunciations.
            proposed: what pocketsphinx found, if anything.
        """
        rewards, sentences = self._laid_out(tuple(commands))
        rewards = rewards + PROPOSED * np.array([command == proposed for command in commands])
        found = best_matches(*sounds, sentences)
        moment = MOMENT / SAMPLE_RATE
        columns = (found.scores + rewards, found.begins * moment, (found.ends + 1) * moment)
        matches = map(Match._make, zip(*(column.tolist() for column in columns), strict=True))
        return Ranking(dict(zip(commands, matches, strict=True)))

    def phones(self, text: str) -> int:
        """Count the phones of a sentence, its words pronounced the first way."""
        return sum(len(self._pronunciations[word][0]) for word in text.split())

    def _lay_out(self, commands: tuple[str, ...]) -> tuple[Floats, Lattice]:
        """Lay out the commands, and count what their phones speak for them, nats."""
        words = [[self._pronunciations[word] for word in text.split()] for text in commands]
        phones = np.array([*map(self.phones, commands)])
        return np.maximum(PHONE * phones, LEAST_REWARD), lattice(words, self._blank)


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


def scorer_for(language: Language, network: str | None = None) -> PhonemeScorer:
    """Load the second ear for the words of a language; the rest is as with `PhonemeScorer`.

    Phones of another language may be called like English ones, and be other sounds.
    """
    if not language.spoken.is_english:
        raise UnknownNetworkError(f"it knows English alone, and this is {language.spoken.name}")
    return PhonemeScorer(spellings(language.pronunciations), network=network)


def why_missing(files: LanguageFiles, network: str | None = None) -> str | None:
    """Say why there is no second ear for a language; None if there is one.

    Raises:
        VozError: the language files, or the file of the network, cannot be used.
    """
    try:
        scorer_for(load_language(files), network)
    except UnknownNetworkError as error:
        return str(error)
    return None


def read_phone_symbols() -> dict[str, list[str]]:
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
