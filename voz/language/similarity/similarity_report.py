"""Tells which commands sound alike, and which to reword; pure."""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence

from voz.language.similarity.confusion import SimilarPair

WARNING_SIMILARITY = 0.77
"""From here on a pair is worth a warning.

In the list that comes with voz these are four pairs, `start speech` and `stop speech` first.
"""

MAX_COMPARED_COMMANDS = 100
"""Of more, only some are compared: it takes a time that grows with their square.

14 commands take 10 ms, 100 about a second, 300 ten times as long; of so many, dozens are alike.
"""

LONG_SENTENCE_WORDS = 3
"""Words; of longer sentences it is said in which words they differ."""

MAX_REPORT_LINES = 10
"""Of warnings: what is read. The worst come first."""

STEEPNESS = 13.3
"""How fast mistakes become rare as two commands are less alike, see `confusion_rate`."""

NEVER_REWORDED = frozenset({"stop"})
"""The one command that works always (S1): everybody must be able to guess it."""


def similarity_warnings(pairs: Sequence[SimilarPair], every: bool = False) -> tuple[str, ...]:
    """Tell the user which pairs are risky, and which of the two to reword.

    Args:
        pairs: those that sound alike, the most alike first.
        every: whether each pair has a line; else there are at most `MAX_REPORT_LINES`.

    Returns:
        A line for each pair, the most alike first; if there are too many, the last line says how
        many more there are.
    """
    risky = [pair for pair in pairs if pair.similarity >= WARNING_SIMILARITY]
    if every or len(risky) <= MAX_REPORT_LINES:
        return tuple(_warning(pair, pairs) for pair in risky)
    lines = [_warning(pair, pairs) for pair in risky[: MAX_REPORT_LINES - 1]]
    more = len(risky) - len(lines)
    return (*lines, f"{more} more pairs sound alike; `voz build-lm --all` shows them")


def confusion_rate(alike: float) -> float:
    """Estimate how often a command is taken for one that sounds so much like it, in noise.

    Half the time if they sound the same. `benchmarks/mixing.py` measures it on the 14 commands of
    eight synthetic voices, both ears together: in white noise at 5 dB .031 of 32 above .8, .025 of
    81 at .75 to .8, none of 99 at .7 to .75, .001 of 731 at .5 to .6. In quiet it is one of 1,482,
    at 0 dB twice as many and more. Above .85 nothing was measured.

    Args:
        alike: from 0 to 1, as in `SimilarPair`.
    """
    return 0.5 * math.exp(-STEEPNESS * (1 - alike))


def rate_in_words(alike: float) -> str:
    """Say in words how often two commands are taken for each other in noise."""
    share = confusion_rate(alike)
    return f"{100 * share:.0f} in 100" if share >= 0.01 else f"{1000 * share:.0f} in 1000"


def command_to_reword(pair: SimilarPair, pairs: Iterable[SimilarPair]) -> str:
    """Suggest which command of a pair to reword: the one that is also close to more others.

    Args:
        pair: the two commands.
        pairs: all pairs that sound alike.

    Returns:
        The command; of two that are equally close to others the one that is later in the list.
    """
    others = [other for other in pairs if other != pair]

    def closeness(command: str) -> float:
        return sum(other.similarity for other in others if command in (other.first, other.second))

    candidates = [c for c in (pair.second, pair.first) if c not in NEVER_REWORDED]
    return max(candidates, key=closeness)


def similarity_table(pairs: Sequence[SimilarPair], every: bool = False) -> str:
    """Write the closest pairs as a table.

    Args:
        pairs: those that sound alike, the most alike first.
        every: whether all are written; else at most `MAX_REPORT_LINES`.

    Returns:
        Lines to print; one that says so if there are no such pairs.
    """
    if not pairs:
        return "no two commands sound alike"
    rows = [("alike", "mixed up in noise", "commands", "", "what differs")]
    rows += [
        (f"{p.similarity:.2f}", rate_in_words(p.similarity), p.first, p.second, _versus(p))
        for p in (pairs if every else pairs[:MAX_REPORT_LINES])
    ]
    widths = [max(map(len, column)) for column in zip(*rows, strict=True)]
    lines = ("  ".join(map(str.ljust, row, widths)).rstrip() for row in rows)
    return "\n".join(lines)


def _warning(pair: SimilarPair, pairs: Sequence[SimilarPair]) -> str:
    differ = f"{_versus(pair)} differ" if any(pair.differ) else "no phone differs"
    return (
        f'"{pair.first}" and "{pair.second}" sound alike ({pair.similarity:.2f}: {differ}; '
        f"{rate_in_words(pair.similarity)} are mixed up in noise); use another word for one, "
        f'best in "{command_to_reword(pair, pairs)}"{rewording_advice(pair)}'
    )


def rewording_advice(pair: SimilarPair) -> str:
    """Say which words of a pair would have to be others; empty if the pair is short enough."""
    if max(len(pair.first.split()), len(pair.second.split())) < LONG_SENTENCE_WORDS:
        return ""
    words = " or ".join(f'"{words}"' for words in sorted(differing_sets(pair)) if words)
    return f": say {words} in another way, or with a word more"


def differing_sets(pair: SimilarPair) -> frozenset[str]:
    """The words of each that the other does not share at its beginning or end."""
    return frozenset(differing_words(pair.first, pair.second))


def differing_words(first: str, second: str) -> tuple[str, str]:
    """Leave out the words that two sentences both begin with, and those that both end with."""
    one, other = first.split(), second.split()
    while one and other and one[0] == other[0]:
        del one[0], other[0]
    while one and other and one[-1] == other[-1]:
        del one[-1], other[-1]
    return " ".join(one), " ".join(other)


def _versus(pair: SimilarPair) -> str:
    return " / ".join(phones or "nothing" for phones in pair.differ) if any(pair.differ) else ""
