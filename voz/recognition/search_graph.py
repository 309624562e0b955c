"""What is searched: each command, and any phones; pure."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from itertools import count
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
        ends: the last state of each command.
        loop: the state of any phones.
    """

    arcs: list[Arc]
    ends: dict[str, int]
    loop: int


def phone_word(phone: str) -> str:
    """Name the word that is a phone alone; no command has an underscore."""
    return f"_{phone}"


def search_graph(commands: Sequence[str], loop: Sequence[str]) -> Graph:
    """Lay commands and a loop of phones side by side.

    Commands that begin alike share that part: the scores are the same with less to search.

    Args:
        commands: the sentences, with one space between their words.
        loop: the phones of the loop.

    Returns:
        The graph; there may be silence before and after every word, and in the loop.
    """
    arcs: list[Arc] = []
    state = count(1)
    ends = {"": 0}  # of every beginning of a command
    for before, word, after in _steps(commands):
        if after not in ends:
            ends[after] = next(state)
            arcs.append((ends[before], ends[after], 1.0, word))
    any_phones = next(state)
    arcs.append((0, any_phones, 1.0))
    arcs += [(any_phones, any_phones, 1 / len(loop), phone_word(phone)) for phone in loop]
    arcs += [(at, at, SILENCE_WEIGHT, SILENCE) for at in (*ends.values(), any_phones)]
    return Graph(arcs, {command: ends[command] for command in commands}, any_phones)


def _steps(commands: Iterable[str]) -> Iterator[tuple[str, str, str]]:
    """Each word of each command, with what of the command is before it, and that with the word."""
    for command in commands:
        words = command.split()
        for number, word in enumerate(words):
            yield " ".join(words[:number]), word, " ".join(words[: number + 1])
