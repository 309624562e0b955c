"""Rival words: those of the dictionary that are one phone away from a word of the list; pure.

A command with a rival word in place of its own, as "cold arm" for "fold arm", is what people say
that sounds most like it, and is no command.
"""

from __future__ import annotations

from collections.abc import Collection, Iterable, Iterator, Mapping

from voz.language.pronunciation import PHONES

Rivals = Mapping[str, Mapping[str, tuple[str, ...]]]
"""For each word the pronunciations that are one phone away, such as "K OW L D", and the words that
are said so."""


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
