"""Whether a sentence with slots may have been another one, as `milk` for `skim milk`."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from typing import TypeGuard

from voz.language.sentences.command_set import Parse
from voz.recognition.confidence import multiply_odds
from voz.recognition.phoneme_scorer import Ranking

RIVAL_SCALE = 3.0
"""Nats of the network that count as one: scores of neighboring symbols err together."""

MIN_SHARE = 0.55
"""A sentence with less than this share is refused."""

BEGUN_AHEAD = 1.0
"""A beginning that fits better by so many nats is as likely as the whole sentence, and each nat
more or less counts whole: what both have in common errs alike (`benchmarks/slots.py`)."""

MOST_AHEAD = 100.0
"""What is ahead by more, in the powers of e, is sure in any case."""

ODDS_OF_SHARE = 3.2
"""How much higher the odds of a meaning are than those of its share (`benchmarks/slots.py`)."""


@dataclass(frozen=True)
class Begun:
    """The likeliest words that begin a sentence, but not the best one, and their score, nats."""

    text: str
    score: float


@dataclass(frozen=True)
class Rival:
    """The likeliest sentence of another meaning, and the share (0 to 1) of the best one."""

    text: str
    share: float
    is_begun: bool = False  # it is not a whole sentence: its end was not heard, or is not yet said


def find_rival(
    ranking: Ranking, parse: Callable[[str], Parse | None], begun: Begun | None = None
) -> Rival | None:
    """Find the likeliest sentence of another meaning than the best one.

    Args:
        ranking: the sentences by their scores.
        parse: returns the meaning of a sentence.
        begun: a sentence of which only the beginning may have been heard.

    Returns:
        None for a sentence without slots, or if no other meaning is there.
    """
    said = parse(ranking.text)
    if said is None or not said.slots:
        return None
    best: dict[object, tuple[float, str]] = {}
    for text, match in ranking.matches.items():
        key = _key(parse(text))
        best[key] = max(best.get(key, (match.score, text)), (match.score, text))
    highest, _ = best.pop(_key(said))
    ahead = [((score - highest) / RIVAL_SCALE, text, False) for score, text in best.values()]
    if begun and begun.text:
        ahead.append((begun.score - highest - BEGUN_AHEAD, begun.text, True))
    if not ahead:
        return None
    others = sum(math.exp(min(each, MOST_AHEAD)) for each, _, _ in ahead)
    _, nearest, is_begun = max(ahead)
    return Rival(nearest, 1 / (1 + others), is_begun)


def is_too_close(other: Rival | None) -> TypeGuard[Rival]:
    """Whether a command is refused for its rival."""
    return other is not None and other.share < MIN_SHARE


def highest_confidence(other: Rival | None) -> float:
    """The confidence that a rival leaves to a command at most, 0 to 1."""
    return 1.0 if other is None else multiply_odds(other.share, ODDS_OF_SHARE)


def _key(parse: Parse | None) -> object:
    """Equal for sentences of the same meaning."""
    return parse and (parse.command, tuple(sorted(parse.slots.items())))
