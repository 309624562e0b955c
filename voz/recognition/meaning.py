"""Whether a sentence with slots may as well have been another one: pure.

The confidence tells whether a command was said at all. In an order of 60 phones it hardly counts
that `milk` may have been `skim milk`. That is asked here.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import NamedTuple, TypeGuard

from voz.language.templates.commands import Parse
from voz.recognition.evidence import Evidence, worth

SCALE = 6.0
"""Nats of both ears that count as one, for the root of each phone: what is beside each other is
wrong together.

Fitted on what is accepted of orders of coffee (158) and of angles (`turn left fifteen degrees`,
261) in kitchens, cafes and white noise, spoken by synthetic voices; the best for each alone is 6 to
7 and 5 to 6.
"""

ENOUGH = 0.6
"""Of the share. Of those 66 are wrong and 353 right, and 28 and 326 pass; of 138 other orders, by
other voices, 13 and 125, and 11 and 122 pass."""


class Rival(NamedTuple):
    """The likeliest sentence that means something else, and what share is left beside all those.

    Attributes:
        text: the sentence.
        left: the share of the sentence that fits best, 0 to 1.
    """

    text: str
    left: float


def rival(evidence: Evidence, parse: Callable[[str], Parse | None]) -> Rival | None:
    """Find what stands in the way of the sentence that fits best.

    Args:
        evidence: what speaks for it and for the others.
        parse: tells what a sentence means.

    Returns:
        The rival; None for a sentence without slots, if nothing else is like it, or if there is no
        second ear: one alone does not tell them apart well enough.
    """
    opinion, said = evidence.opinion, parse(evidence.text)
    if opinion is None or said is None or not said.slots:
        return None
    meant = _key(said)
    best = {meant: (worth(evidence.command.score, opinion.fits[evidence.text]), evidence.text)}
    for text, score in evidence.rivals.items():
        key, found = _key(parse(text)), (worth(score, opinion.fits[text]), text)
        best[key] = max(best.get(key, found), found)
    highest, _ = best.pop(meant)
    if not best:
        return None
    scale = SCALE * math.sqrt(opinion.fits[evidence.text].phones)
    others = sum(math.exp((score - highest) / scale) for score, _ in best.values())
    return Rival(max(best.values())[1], 1 / (1 + others))


def stands_in_the_way(against: Rival | None) -> TypeGuard[Rival]:
    """Tell whether a rival is reason enough to refuse a command."""
    return against is not None and against.left < ENOUGH


def most_sure(against: Rival | None) -> float:
    """Tell how sure a command may be for its rivals, 0 to 1."""
    return against.left if stands_in_the_way(against) else 1.0


def _key(parse: Parse | None) -> object:
    """What sentences that mean the same have in common."""
    return parse and (parse.command, tuple(sorted(parse.slots.items())))
