"""The search graph of commands and a loop of phones."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from itertools import count
from typing import NamedTuple

Arc = tuple[int, int, float, str] | tuple[int, int, float]
"""From one state to another with a weight, and a word unless it is an empty transition."""

SILENCE = "<sil>"

SILENCE_WEIGHT = 0.005
"""pocketsphinx's `silprob`."""


class Graph(NamedTuple):
    """The arcs from state 0, the last state of each command, and the state of the phone loop."""

    arcs: list[Arc]
    ends: dict[str, int]
    loop: int


def phone_word(phone: str) -> str:
    """The word of a single phone; no command has an underscore."""
    return f"_{phone}"


def search_graph(commands: Sequence[str], loop: Sequence[str]) -> Graph:
    """Build a prefix tree of commands beside a loop of phones, with silences everywhere."""
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
    """Each word of each command, with the command before it, and with it."""
    for command in commands:
        words = command.split()
        for number, word in enumerate(words):
            yield " ".join(words[:number]), word, " ".join(words[: number + 1])
