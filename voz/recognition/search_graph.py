"""What is searched: each command, each command spelled by its phones, and any phones; pure."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping, Sequence
from itertools import count, pairwise
from typing import NamedTuple

Arc = tuple[int, int, float, str] | tuple[int, int, float]
"""From one state to another with a weight, and a word unless it is passed at no cost."""

SILENCE = "<sil>"

SILENCE_WEIGHT = 0.005
"""pocketsphinx's own `silprob`, which it uses for the silences that it adds itself."""


class Graph(NamedTuple):
    """The arcs of a search from state 0, and where what is to be found ends.

    Attributes:
        arcs: all of them.
        ends: the last state of each command, as a chain of words.
        spelled: the same as a chain of phones.
        loop: the state of any phones.
    """

    arcs: list[Arc]
    ends: dict[str, int]
    spelled: dict[str, int]
    loop: int


def phone_word(phone: str) -> str:
    """Name the word that is a phone alone; no command has an underscore."""
    return f"_{phone}"


def search_graph(
    commands: Sequence[str], spellings: Mapping[str, Sequence[Sequence[str]]], loop: Sequence[str]
) -> Graph:
    """Lay commands, their phones and a loop of phones side by side.

    Commands that begin alike share that part: the scores are the same with less to search.

    Args:
        commands: the sentences, with one space between their words.
        spellings: the phones of each word, in all the ways that it may be said.
        loop: the phones of the loop.

    Returns:
        The graph; there may be silence before and after every word, and in the loop.
    """
    arcs: list[Arc] = []
    state = count(1)
    ends, spelled = {"": 0}, {"": 0}  # of every beginning of a command
    for before, word, after in _steps(commands):
        if after in ends:
            continue
        ends[after], spelled[after] = next(state), next(state)
        arcs.append((ends[before], ends[after], 1.0, word))
        for phones in spellings[word]:
            inside = [next(state) for _ in phones[1:]]
            path = pairwise([spelled[before], *inside, spelled[after]])
            arcs += [(*pair, 1.0, phone_word(p)) for pair, p in zip(path, phones, strict=True)]
    any_phones = next(state)
    arcs.append((0, any_phones, 1.0))
    arcs += [(any_phones, any_phones, 1 / len(loop), phone_word(phone)) for phone in loop]
    pauses = {*ends.values(), *spelled.values(), any_phones}
    arcs += [(at, at, SILENCE_WEIGHT, SILENCE) for at in sorted(pauses)]
    return Graph(arcs, _of(commands, ends), _of(commands, spelled), any_phones)


def _steps(commands: Iterable[str]) -> Iterator[tuple[str, str, str]]:
    """Each word of each command, with what of the command is before it, and that with the word."""
    for command in commands:
        words = command.split()
        for number, word in enumerate(words):
            yield " ".join(words[:number]), word, " ".join(words[: number + 1])


def _of(commands: Iterable[str], states: Mapping[str, int]) -> dict[str, int]:
    return {command: states[command] for command in commands}
