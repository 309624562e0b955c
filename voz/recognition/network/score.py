"""Scores commands against a sound by the phonemes that the network finds in it.

The score of a command adds up over its phones, in nats, wherever in the sound the command is.
"""

from __future__ import annotations

from collections.abc import Collection, Iterable, Mapping, Sequence
from functools import cached_property, lru_cache
from pathlib import Path
from typing import NamedTuple

import numpy as np

from voz.audio import SAMPLE_RATE, Samples
from voz.audio.echo import Cleaned
from voz.audio.sound_files import to_int16
from voz.errors import ConfigError
from voz.language.language_files import LanguageFiles
from voz.language.sentences.automaton import Automaton
from voz.language.sentences.command_set import Commands
from voz.recognition.language import Language, load_language, spellings
from voz.recognition.network.ctc import (
    Floats,
    Lattice,
    SentenceSearch,
    align,
    best_matches,
    lattice,
    longest_gap,
)
from voz.recognition.network.phoneme_network import (
    BLANKS,
    DEFAULT_NETWORK,
    MOMENT,
    OTHER_LANGUAGES,
    PhonemeNetwork,
    UnknownNetworkError,
)
from voz.recognition.network.rival_words import RivalWords
from voz.recognition.network.symbols import (
    read_phone_symbols,
    symbols_of_other_languages,
    symbols_of_phones,
    unstressed,
    with_symbols,
)

MIN_PROBABILITY = 1e-10
"""Floor of the probability of a phone."""

CACHED_LATTICES = 4
"""How many lists of commands keep their lattice."""

REWARD_PER_PHONE = 2.0
"""Nats for each phone of a command."""

MIN_REWARD = 7.0
"""Nats for a command of few phones, as `up` or `no`, which `REWARD_PER_PHONE` alone would miss."""

PENALTY_PER_OTHER_PHONE = 2.5
"""Nats against a command for each phone before or after it."""

PROPOSAL_BONUS = 1.0
"""Nats for the command that pocketsphinx found."""

SHORT_WORDS, MAX_SUPPORT = 3, 6.0
"""An order with slots that means what pocketsphinx found has a nat for each word from the fourth
on, up to so many: in long orders the two err in different places (`benchmarks/intents.py`)."""

FIRST_PHONE_SECONDS = 0.12
"""The network reports a phone near its end: a word begins this much before its first one, unless
the word before it ends later (`benchmarks/word_times.py`).
"""

MATCH_MARGIN = 0.2
"""What is compared with a command begins and ends within this much (s) around it."""

MAX_LEAD_BONUS = 6.0
"""Most nats for being ahead of the next best command."""

NETWORK_ADVICE = "name a file of weights that `training/teach.py` made"

MAX_PLAYBACK_LAG = 2
"""Moments by which the network may find a phone sooner or later in playback than in its echo."""


class Match(NamedTuple):
    """Where in the samples a command fits best, s, and its score, nats."""

    score: float
    begin: float
    end: float


class PhoneLikelihoods(NamedTuple):
    """The phones in a sound.

    Attributes:
        log_ratios: log-probabilities less that of the likeliest symbol, nats, moments x phones.
        begin_penalties: nats against a command that begins at each moment.
        end_penalties: nats against a command that ends at each moment.
    """

    log_ratios: Floats
    begin_penalties: Floats
    end_penalties: Floats


class Ranking:
    """Commands by their scores."""

    def __init__(self, matches: Mapping[str, Match], supported: Collection[str] = ()) -> None:
        """Take the matches, and which commands mean what pocketsphinx found, if it has a say."""
        self.matches = matches
        self._supported = frozenset(supported)

    def rank_score(self, command: str) -> float:
        """The score by which a command stands before others, nats."""
        score = self.matches[command].score
        if command not in self._supported:
            return score
        return score + min(MAX_SUPPORT, max(0, len(command.split()) - SHORT_WORDS))

    @cached_property
    def text(self) -> str:
        """The command that fits best."""
        return max(self.matches, key=self.rank_score)

    @cached_property
    def next_best(self) -> str:
        """The second best command; empty if there is no other."""
        others = (command for command in self.matches if command != self.text)
        return max(others, key=self.rank_score, default="")

    @cached_property
    def score(self) -> float:
        """The score of the best command and half its lead over the next one, nats."""
        best = self.matches[self.text].score
        if not self.next_best:
            return best + MAX_LEAD_BONUS
        return best + min(MAX_LEAD_BONUS, (best - self.matches[self.next_best].score) / 2)

    def others(self, count: int) -> list[tuple[str, float]]:
        """So many other commands, the best first, and the score of each as if it were the best.

        Being behind the best counts against a command as being ahead counts for it.
        """
        best = self.matches[self.text].score
        highest = self.rank_score(self.text)
        behind = {text: highest - self.rank_score(text) for text in self.matches}
        del behind[self.text]
        nearest = sorted(behind, key=behind.__getitem__)[:count]
        return [(t, best - behind[t] - min(MAX_LEAD_BONUS, behind[t] / 2)) for t in nearest]


class PhonemeScorer:
    """Scores the commands of a language."""

    def __init__(
        self,
        spellings: Mapping[str, Iterable[Sequence[str]]],
        network: Path = DEFAULT_NETWORK,
        rivals: Mapping[str, Iterable[Sequence[str]]] | None = None,
    ) -> None:
        """Load the network.

        Args:
            spellings: all pronunciations of each word.
            network: a file of weights.
            rivals: the pronunciations of what sounds much like some of the words.

        Raises:
            ConfigError: the file cannot be used.
            UnknownNetworkError: the network lacks a phone.
        """
        self._network = load_network(network)
        known = {word: list(spelled) for word, spelled in spellings.items()}
        symbols = {phone: dict.fromkeys(said, 1.0) for phone, said in read_phone_symbols().items()}
        if any(phone not in symbols for ways in known.values() for way in ways for phone in way):
            symbols |= symbols_of_other_languages()
        if lacking := {s for sounds in symbols.values() for s in sounds} - {*self._network.symbols}:
            raise ConfigError(f"{network}: has no symbol {min(lacking)}; {NETWORK_ADVICE}")
        unknown = {p for spelled in known.values() for phones in spelled for p in phones}
        unknown -= {*symbols}
        if unknown:
            raise UnknownNetworkError(f"it knows no phone {' or '.join(sorted(unknown))}")
        numbers = {phone: number for number, phone in enumerate(symbols)}
        self._pronunciations = {
            word: [[numbers[phone] for phone in phones] for phones in spelled]
            for word, spelled in known.items()
        }
        self._blank = len(symbols)
        self._rival_words = RivalWords(
            self._pronunciations,
            {
                word: [[numbers[phone] for phone in way] for way in ways]
                for word, ways in (rivals or {}).items()
            },
            self._blank,
            REWARD_PER_PHONE,
        )
        self._symbols_of_phones = symbols_of_phones(self._network.symbols, symbols.values())
        self._rewards_and_lattice = lru_cache(CACHED_LATTICES)(self._make_lattice)

    def phone_likelihoods(self, samples: Samples) -> PhoneLikelihoods:
        """Find the phones in samples of 16 kHz, not denoised."""
        return self._likelihoods(self._probabilities(samples))

    def phones_of_sentence(self, samples: Samples) -> PhoneLikelihoods:
        """Find the phones in samples of 16 kHz that may hold a long sentence, not denoised."""
        found = self._network.log_probabilities_in_windows(samples)
        return self._likelihoods(np.exp(found).astype(np.float64))

    def count_heard(self, samples: Samples) -> int:
        """Count the phones that are the likeliest symbols somewhere in samples of 16 kHz."""
        penalties = self.phone_likelihoods(samples).begin_penalties
        return round(float(penalties[-1]) / PENALTY_PER_OTHER_PHONE)

    def phones_over_playback(self, sound: Cleaned) -> PhoneLikelihoods:
        """Find the phones in sound that was cleaned of playback.

        Those of the playback are taken for silence where nobody is heard over it.
        """
        probabilities = self._probabilities(sound.samples)
        playback = self._probabilities(to_int16(sound.played))
        middles = np.arange(len(probabilities)) * MOMENT + MOMENT // 2
        may_be_played = sound.may_be_played()[np.minimum(middles, len(sound.samples) - 1)]
        _silence(probabilities, playback * may_be_played[:, np.newaxis])
        return self._likelihoods(probabilities)

    def _likelihoods(self, probabilities: Floats) -> PhoneLikelihoods:
        blank = probabilities[:, -BLANKS:].sum(axis=1)
        likeliest = probabilities[:, :-BLANKS].max(axis=1)
        phones = np.where(blank < likeliest, probabilities[:, :-BLANKS].argmax(axis=1), -1)
        begun = np.cumsum((phones >= 0) & (phones != np.concatenate([[-1], phones[:-1]])))
        of_phones = np.maximum(probabilities @ self._symbols_of_phones, MIN_PROBABILITY)
        return PhoneLikelihoods(
            np.log(of_phones / np.maximum(likeliest, blank)[:, np.newaxis]),
            PENALTY_PER_OTHER_PHONE * np.concatenate([[0], begun[:-1]]),
            PENALTY_PER_OTHER_PHONE * (begun[-1] - begun),
        )

    def _probabilities(self, samples: Samples) -> Floats:
        probabilities: Floats = np.exp(self._network.log_probabilities(samples)).astype(np.float64)
        return probabilities

    def rank(
        self, likelihoods: PhoneLikelihoods, commands: Collection[str], proposed: str = ""
    ) -> Ranking:
        """Score commands.

        Args:
            likelihoods: of the phones.
            commands: at least one; their words have pronunciations.
            proposed: what pocketsphinx found, if anything.
        """
        rewards, sentences = self._rewards_and_lattice(tuple(commands))
        rewards = rewards + PROPOSAL_BONUS * np.array([command == proposed for command in commands])
        found = best_matches(*likelihoods, sentences)
        moment = MOMENT / SAMPLE_RATE
        columns = (found.scores + rewards, found.begins * moment, (found.ends + 1) * moment)
        matches = map(Match._make, zip(*(column.tolist() for column in columns), strict=True))
        return Ranking(dict(zip(commands, matches, strict=True)))

    def rival_lead(self, likelihoods: PhoneLikelihoods, text: str, match: Match) -> float | None:
        """How much better a command fits with a rival word in it, nats; None if it has none.

        Args:
            likelihoods: of the phones.
            text: the command.
            match: where it fits best.
        """
        return self._rival_words.lead(text, *_around(likelihoods, match))

    def longest_gap(self, likelihoods: PhoneLikelihoods, text: str, match: Match) -> float:
        """The longest time (s) without a phone within a word of a command; arguments as above."""
        moments = longest_gap(*_around(likelihoods, match), self.lattice_of(text))
        return moments * MOMENT / SAMPLE_RATE

    def align(self, likelihoods: PhoneLikelihoods, text: str) -> list[tuple[float, float]]:
        """Find where each word of a sentence that fits begins and ends in the sound, s."""
        found: list[tuple[float, float]] = []
        end = 0.0
        for first, last in align(*likelihoods, self.lattice_of(text)):
            begin = max(end, first * MOMENT / SAMPLE_RATE - FIRST_PHONE_SECONDS)
            end = (last + 1) * MOMENT / SAMPLE_RATE
            found.append((begin, end))
        return found

    def sentence_search(self, automaton: Automaton) -> SentenceSearch:
        """Prepare to search all sentences of an automaton."""
        return SentenceSearch(automaton, self._pronunciations, self._blank, REWARD_PER_PHONE)

    def lattice_of(self, *sentences: str) -> Lattice:
        """The lattice of sentences; their words have pronunciations."""
        words = [[self._pronunciations[word] for word in text.split()] for text in sentences]
        return lattice(words, self._blank)

    def phone_numbers(self, text: str) -> list[int]:
        """The phones of a sentence, as they are numbered in `log_ratios` of `PhoneLikelihoods`.

        By the first pronunciation of each word.
        """
        return [number for word in text.split() for number in self._pronunciations[word][0]]

    def count_phones(self, text: str) -> int:
        """Count the phones of a sentence by the first pronunciation of each word."""
        return len(self.phone_numbers(text))

    def _make_lattice(self, commands: tuple[str, ...]) -> tuple[Floats, Lattice]:
        phones = np.array([*map(self.count_phones, commands)])
        return np.maximum(REWARD_PER_PHONE * phones, MIN_REWARD), self.lattice_of(*commands)


def _around(likelihoods: PhoneLikelihoods, match: Match) -> PhoneLikelihoods:
    """The likelihoods around a match."""
    first = max(0, round((match.begin - MATCH_MARGIN) * SAMPLE_RATE / MOMENT))
    last = round((match.end + MATCH_MARGIN) * SAMPLE_RATE / MOMENT)
    return PhoneLikelihoods(*(part[first:last] for part in likelihoods))


def network_file(files: LanguageFiles, named: str | None) -> Path:
    """The file of weights for a language: the one that is named, or voz's own."""
    own = OTHER_LANGUAGES if files.ipa.exists() else DEFAULT_NETWORK
    return Path(named) if named else own


def load_network(path: Path = DEFAULT_NETWORK) -> PhonemeNetwork:
    """Load a file of weights; ConfigError if it cannot be used."""
    try:
        return PhonemeNetwork(path)
    except UnknownNetworkError as error:
        raise ConfigError(f"{error}; {NETWORK_ADVICE}") from None


def scorer_for(language: Language, network: str | None = None) -> PhonemeScorer:
    """Make a `PhonemeScorer` for a language.

    Raises:
        ConfigError: the file of weights cannot be used.
        UnknownNetworkError: it does not know the phones of the language; those of a model of the
            user's may have English names.
    """
    if not language.network_words:
        raise UnknownNetworkError(f"it does not know the phones of {language.spoken.name}")
    words = spellings(language.network_words)
    if language.ipa:
        words = {word: [*map(with_symbols, ways)] for word, ways in words.items()}
        for word in _unstressed_words(words, language.commands):
            words[word] = [*map(unstressed, words[word])]
    rivals = {
        word: [with_symbols(way.split()) if language.ipa else way.split() for way in ways]
        for word, ways in language.rivals.items()
    }
    return PhonemeScorer(words, network_file(language.files, network), rivals)


def _unstressed_words(
    spellings: Mapping[str, Sequence[Sequence[str]]], commands: Commands
) -> set[str]:
    """The words of one phone without which no sentence is another one.

    There are none if the list is too long, or has slots: `vingt et un` without two words is another
    number.
    """
    found = {word for word, ways in spellings.items() if all(len(way) == 1 for way in ways)}
    if not found or commands.have_slots or not commands.can_be_listed:
        return set()
    for words in map(str.split, commands.listed):
        for place in range(len(words)):
            rest = [*words[:place], *words[place + 1 :]]
            if words[place] in found and (not rest or " ".join(rest) in commands):
                found.remove(words[place])
    return found


def why_missing(files: LanguageFiles, network: str | None = None) -> str | None:
    """The reason why the network cannot be used for a language; None if it can.

    Raises:
        VozError: the language files, or the file of weights, cannot be used.
    """
    try:
        scorer_for(load_language(files), network)
    except UnknownNetworkError as error:
        return str(error)
    return None


def _silence(probabilities: Floats, playback: Floats) -> None:
    """Make the blank of symbols as probable as they are in the playback just then."""
    share = playback[:, :-BLANKS].copy()
    for moments in range(1, MAX_PLAYBACK_LAG + 1):
        np.maximum(share[moments:], playback[:-moments, :-BLANKS], out=share[moments:])
        np.maximum(share[:-moments], playback[moments:, :-BLANKS], out=share[:-moments])
    removed = probabilities[:, :-BLANKS] * share
    probabilities[:, :-BLANKS] -= removed
    probabilities[:, -1] += removed.sum(axis=1)
