"""Whether a sentence with slots may have been another one, as `milk` for `skim milk`."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from typing import TypeGuard

from voz.language.sentences.command_set import Parse
from voz.recognition.phoneme_scorer import Ranking

RIVAL_SCALE = 3.0
"""Nats of the network that count as one: scores of neighboring symbols err together."""

MIN_SHARE = 0.55
"""A sentence with less than this share is refused."""


@dataclass(frozen=True)
class Rival:
    """The likeliest sentence of another meaning, and the share (0 to 1) of the best one."""

    text: str
    share: float


def find_rival(ranking: Ranking, parse: Callable[[str], Parse | None]) -> Rival | None:
    """Find the likeliest sentence of another meaning than the best one.

    Args:
        ranking: the sentences by their scores.
        parse: returns the meaning of a sentence.

    Returns:
        None for a sentence without slots, or if no other meaning is there.
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
    others = sum(math.exp((score - highest) / RIVAL_SCALE) for score, _ in best.values())
    return Rival(max(best.values())[1], 1 / (1 + others))


def is_too_close(other: Rival | None) -> TypeGuard[Rival]:
    """Whether a command is refused for its rival."""
    return other is not None and other.share < MIN_SHARE


def highest_confidence(other: Rival | None) -> float:
    """The confidence that a rival leaves to a command at most, 0 to 1."""
    return other.share if is_too_close(other) else 1.0


def _key(parse: Parse | None) -> object:
    """Equal for sentences of the same meaning."""
    return parse and (parse.command, tuple(sorted(parse.slots.items())))
