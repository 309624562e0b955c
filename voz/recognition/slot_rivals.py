"""Whether a sentence with slots may as well have been another one: pure.

The confidence tells whether a command was said at all. In an order of 60 phones it hardly counts
that `milk` may have been `skim milk`. That is asked here.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import NamedTuple, TypeGuard

from voz.language.sentences.command_set import Parse
from voz.recognition.phoneme_scorer import Ranking

SCALE = 3.0
"""Nats of the network that count as one: what is beside each other is wrong together."""

ENOUGH = 0.55
"""Of the share."""


class Rival(NamedTuple):
    """The likeliest sentence that means something else, and what share is left beside all those.

    Attributes:
        text: the sentence.
        left: the share of the sentence that fits best, 0 to 1.
    """

    text: str
    left: float


def find_rival(ranking: Ranking, parse: Callable[[str], Parse | None]) -> Rival | None:
    """Find what stands in the way of the sentence that fits best.

    Args:
        ranking: what the network makes of the sentences.
        parse: tells what a sentence means.

    Returns:
        The rival; None for a sentence without slots, or if nothing else is like it.
    """
    said = parse(ranking.text)
    if said is None or not said.slots:
        return None
    meant = _key(said)
    best: dict[object, tuple[float, str]] = {}
    for text, match in ranking.matches.items():
        key = _key(parse(text))
        best[key] = max(best.get(key, (match.score, text)), (match.score, text))
    highest, _ = best.pop(meant)
    if not best:
        return None
    others = sum(math.exp((score - highest) / SCALE) for score, _ in best.values())
    return Rival(max(best.values())[1], 1 / (1 + others))


def is_too_close(other: Rival | None) -> TypeGuard[Rival]:
    """Whether a rival is reason enough to refuse a command."""
    return other is not None and other.left < ENOUGH


def highest_confidence(other: Rival | None) -> float:
    """The confidence that a rival leaves to a command at most, 0 to 1."""
    return other.left if is_too_close(other) else 1.0


def _key(parse: Parse | None) -> object:
    """What sentences that mean the same have in common."""
    return parse and (parse.command, tuple(sorted(parse.slots.items())))
