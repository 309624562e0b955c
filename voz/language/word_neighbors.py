"""Neighbors of the words of a list: words of the dictionary one phone away, their rivals.

A command with a rival word in place of its own, as "cold arm" for "fold arm", is what people say
that sounds most like it, and is no command. Pure, but for the language model and the words of
other languages.
"""

from __future__ import annotations

import gzip
import math
from collections.abc import Callable, Collection, Iterable, Iterator, Mapping
from pathlib import Path

from voz.language.phones import PHONES, known_phones, read_distances
from voz.language.similarity import loss_between

Rivals = Mapping[str, Mapping[str, tuple[str, ...]]]
"""For each word the pronunciations that are one phone away, such as "K OW L D", and the words that
are said so, if these are known."""

COMMON_WORDS = Path(__file__).with_name("common_words")
"""How the commonest words of other languages are said, by `training/common_words.py`."""

MIN_PHONES = 4
"""A shorter word of another language has no rivals: articles are the rivals of each other, and
people slur them."""

EVERYDAY = math.log(3e-6)
"""Log-probability of a word, from which on it is an everyday one: so rare is the 10,000th."""

MAX_NEIGHBORS = 5
"""So many phrases are named for each command."""


def find_rivals(pronunciations: Mapping[str, Collection[str]], cmudict: bytes) -> Rivals:
    """Find the rival words of each word.

    Args:
        pronunciations: of each word, such as "F OW L D".
        cmudict: what `read_cmudict` returns.
    """
    near = _near(pronunciations, PHONES)
    return _that_are_words(near, _words_said(cmudict, set().union(*near.values())))


def find_rivals_by_sound(
    pronunciations: Mapping[str, Collection[str]], common: Collection[str]
) -> Rivals:
    """The same of another language, of which no words are known but how the common ones are said.

    Args:
        pronunciations: of each word, such as "k a s a".
        common: what `read_common_words` returns.
    """
    long = {
        word: [way for way in ways if len(way.split()) >= MIN_PHONES]
        for word, ways in pronunciations.items()
    }
    phones = {phone for way in common for phone in way.split()}
    return _that_are_words(_near(long, phones), dict.fromkeys(common, ()))


def read_common_words(language: str) -> frozenset[str]:
    """How the common words of a language are said, such as "k a s a"; empty if that is unknown.

    Of a regional language, such as `pt-br`, those of the language.
    """
    path = COMMON_WORDS / f"{language.partition('-')[0]}.gz"
    if not path.exists():
        return frozenset()
    return frozenset(gzip.decompress(path.read_bytes()).decode().splitlines())


def _near(
    pronunciations: Mapping[str, Collection[str]], phones: Collection[str]
) -> dict[str, set[str]]:
    return {
        word: {other for way in ways for other in _one_phone_away(way, phones)} - {*ways}
        for word, ways in pronunciations.items()
    }


def _that_are_words(
    near: Mapping[str, Collection[str]], said_so: Mapping[str, tuple[str, ...]]
) -> dict[str, dict[str, tuple[str, ...]]]:
    return {
        word: {way: said_so[way] for way in sorted(said_so.keys() & ways)}
        for word, ways in near.items()
    }


def _one_phone_away(way: str, phones: Collection[str]) -> Iterator[str]:
    """All that a pronunciation becomes if one phone is another, is left out, or is too many."""
    said = way.split()
    for place in range(len(said) + 1):
        before, after = said[:place], said[place:]
        changes: list[Iterable[str]] = [(phone, *after) for phone in phones]
        if after:
            changes += [after[1:], *((phone, *after[1:]) for phone in phones)]
        for change in changes:
            yield " ".join((*before, *change))


def _words_said(cmudict: bytes, wanted: Collection[str]) -> dict[str, tuple[str, ...]]:
    """The words of a dictionary that are said in one of some ways."""
    found: dict[str, dict[str, None]] = {}
    lines = {phones.encode(): phones for phones in wanted}
    for line in cmudict.split(b"\n"):
        name, _, said = line.partition(b" ")
        if phones := lines.get(said):
            found.setdefault(phones, {})[name.partition(b"(")[0].decode()] = None
    return {phones: tuple(words) for phones, words in found.items()}


def encode_rivals(rivals: Rivals) -> str:
    """As text: lines of a word, a pronunciation one phone away, and the words that are said so."""
    return "".join(
        f"{word}\t{phones}\t{' '.join(words)}\n"
        for word, ways in rivals.items()
        for phones, words in ways.items()
    )


def decode_rivals(text: str) -> Rivals:
    """Read what `encode_rivals` wrote; raises ValueError."""
    found: dict[str, dict[str, tuple[str, ...]]] = {}
    for line in text.splitlines():
        word, phones, words = line.split("\t")
        if not phones or not known_phones().issuperset(phones.split()):
            raise ValueError(f"{phones!a} are not all phones")
        found.setdefault(word, {})[phones] = tuple(words.split())
    return found


def word_log_probability() -> Callable[[str], float]:
    """Load pocketsphinx's English language model: the log-probability of a word, nats."""
    import pocketsphinx

    path = pocketsphinx.get_model_path("en-us/en-us.lm.bin")
    logarithms = pocketsphinx.LogMath()
    config = pocketsphinx.Config(lm=path, hmm=None, dict=None)
    model = pocketsphinx.NGramModel(config, logarithms, path)
    return lambda word: float(logarithms.log_to_ln(model.prob([word])))


def everyday_words(words: Collection[str]) -> frozenset[str]:
    """Those words that are common in the English of pocketsphinx's language model."""
    log_probability = word_log_probability()
    plain = (word for word in words if word.isalpha() and len(word) > 1)
    return frozenset(word for word in plain if log_probability(word) >= EVERYDAY)


def neighbors(
    command: str,
    pronunciations: Mapping[str, Collection[str]],
    rivals: Rivals,
    allowed: Collection[str],
) -> list[str]:
    """Find what sounds most like a command with one word replaced, the nearest first.

    Args:
        command: its words.
        pronunciations: of each of them, such as "F OW L D".
        rivals: what `find_rivals` returns.
        allowed: the words that may replace one.
    """
    apart = read_distances()
    words = command.split()
    losses = {}
    for place, word in enumerate(words):
        for said, others in rivals.get(word, {}).items():
            loss = min(loss_between(w.split(), said.split(), apart) for w in pronunciations[word])
            for other in set(others).intersection(allowed):
                losses[" ".join((*words[:place], other, *words[place + 1 :]))] = loss
    return sorted(losses, key=lambda phrase: (losses[phrase], phrase))[:MAX_NEIGHBORS]
