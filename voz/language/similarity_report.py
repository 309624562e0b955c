"""Reports which commands sound alike, and which to reword; pure."""

from __future__ import annotations

import math
from collections.abc import Collection, Iterable, Mapping, Sequence

from voz.language.similarity import SimilarPair, differing_sets

WARNING_SIMILARITY = 0.88
"""Pairs from here on are warned of: 1 in 100 or more are mixed up in noise as loud as the voice."""

MAX_COMPARED_COMMANDS = 100
"""Of more, a sample is compared: 100 take a second, and time is quadratic."""

LONG_SENTENCE_WORDS = 3
"""From here on a warning names the words that differ."""

MAX_REPORT_LINES = 10
"""The worst come first."""

STEEPNESS = 11.1
"""See `confusion_rate`."""

NEVER_REWORDED = frozenset({"stop"})
"""The command that works always (S1): everybody must be able to guess it."""


def similarity_warnings(
    pairs: Sequence[SimilarPair], every: bool = False, known: Iterable[Collection[str]] = ()
) -> tuple[str, ...]:
    """Warn of risky pairs, the worst first, and which to reword.

    `MAX_REPORT_LINES` are named, or every one; pairs within one of the lists in `known` were told
    of before.
    """
    lists = list(known)
    risky = [
        pair
        for pair in sorted(pairs, key=lambda pair: -pair.similarity)
        if pair.similarity >= WARNING_SIMILARITY
        and not any(pair.first in each and pair.second in each for each in lists)
    ]
    if every or len(risky) <= MAX_REPORT_LINES:
        return tuple(_warning(pair, pairs) for pair in risky)
    lines = [_warning(pair, pairs) for pair in risky[: MAX_REPORT_LINES - 1]]
    more = len(risky) - len(lines)
    return (*lines, f"{more} more pairs sound alike; `voz build-lm --all` shows them")


def confusion_rate(alike: float) -> float:
    """Estimate how often a command is taken for another in noise, from their similarity.

    Fitted by `benchmarks/alike.py` in white noise as loud as the voice, where the recognizer may
    also refuse; the two of a pair that sounds the same are taken for each other half the time.
    """
    return 0.5 * math.exp(-STEEPNESS * math.sqrt(1 - alike))


def rate_in_words(alike: float) -> str:
    """Format a confusion rate, in 100 or in 1000."""
    share = confusion_rate(alike)
    return f"{100 * share:.0f} in 100" if share >= 0.01 else f"{1000 * share:.0f} in 1000"


def command_to_reword(pair: SimilarPair, pairs: Iterable[SimilarPair]) -> str:
    """Choose which command of a pair to reword: the one that is also similar to more others."""
    others = [other for other in pairs if other != pair]

    def closeness(command: str) -> float:
        return sum(other.similarity for other in others if command in (other.first, other.second))

    candidates = [c for c in (pair.second, pair.first) if c not in NEVER_REWORDED]
    return max(candidates, key=closeness)


def similarity_table(pairs: Sequence[SimilarPair], every: bool = False) -> str:
    """Format the most similar pairs; at most `MAX_REPORT_LINES` unless `every`."""
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


def neighbor_table(neighbors: Mapping[str, Sequence[str]], every: bool = False) -> str:
    """Format what else sounds like each command; at most `MAX_REPORT_LINES` unless `every`."""
    told = [(text, ", ".join(near)) for text, near in neighbors.items() if near]
    if not told:
        return "no everyday phrase is one sound away from a command"
    rows = [("command", "one sound away, in everyday words; not all of them are refused"), *told]
    shown = rows if every else rows[: MAX_REPORT_LINES + 1]
    width = max(len(text) for text, _ in shown)
    lines = [f"{text:{width}}  {near}" for text, near in shown]
    if len(shown) < len(rows):
        lines.append(f"and {len(rows) - len(shown)} more commands; `voz build-lm --alike --all`")
    return "\n".join(lines)


def _warning(pair: SimilarPair, pairs: Sequence[SimilarPair]) -> str:
    differ = f"{_versus(pair)} differ" if any(pair.differ) else "no phone differs"
    return (
        f'"{pair.first}" and "{pair.second}" sound alike ({pair.similarity:.2f}: {differ}; '
        f"{rate_in_words(pair.similarity)} are mixed up in noise); use another word for one, "
        f'best in "{command_to_reword(pair, pairs)}"{rewording_advice(pair)}'
    )


def rewording_advice(pair: SimilarPair) -> str:
    """Name the words of a long pair to replace; empty if the pair is short."""
    if max(len(pair.first.split()), len(pair.second.split())) < LONG_SENTENCE_WORDS:
        return ""
    words = " or ".join(f'"{words}"' for words in sorted(differing_sets(pair)) if words)
    return f": say {words} in another way, or with a word more"


def _versus(pair: SimilarPair) -> str:
    return " / ".join(phones or "nothing" for phones in pair.differ) if any(pair.differ) else ""
