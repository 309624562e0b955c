"""Neighbors of the words of a list: words of the dictionary one phone away, their rivals.

A command with a rival word in place of its own, as "cold arm" for "fold arm", is what people say
that sounds most like it, and is no command. Pure, but for the language model.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Collection, Iterable, Iterator, Mapping

from voz.language.phones import PHONES, read_distances
from voz.language.similarity import loss_between

Rivals = Mapping[str, Mapping[str, tuple[str, ...]]]
"""For each word the pronunciations that are one phone away, such as "K OW L D", and the words that
are said so."""

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
    near = {
        word: {other for way in ways for other in _one_phone_away(way)} - {*ways}
        for word, ways in pronunciations.items()
    }
    said_so = _words_said(cmudict, set().union(*near.values()))
    return {
        word: {way: said_so[way] for way in sorted(ways & said_so.keys())}
        for word, ways in near.items()
    }


def _one_phone_away(way: str) -> Iterator[str]:
    """All that a pronunciation becomes if one phone is another, is left out, or is too many."""
    phones = way.split()
    for place in range(len(phones) + 1):
        before, after = phones[:place], phones[place:]
        changes: list[Iterable[str]] = [(phone, *after) for phone in PHONES]
        if after:
            changes += [after[1:], *((phone, *after[1:]) for phone in PHONES)]
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
        if not phones or not PHONES.issuperset(phones.split()):
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
