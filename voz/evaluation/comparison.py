"""Two evaluations of the same clips: which recognises more, and is that by chance? Pure."""

from __future__ import annotations

from collections.abc import Iterable

import msgspec

from voz.evaluation.results import Result
from voz.evaluation.statistics import mcnemar


class Difference(msgspec.Struct, frozen=True):
    """A set of commands, heard in two ways.

    Attributes:
        set: the manifest they come from.
        snr: at which signal-to-noise ratio, dB; None is without added noise.
        clips: how many were heard in both ways.
        this: share of them that is right and accepted here.
        other: the same there.
        only_this: clips that are right and accepted here only.
        only_other: clips that are right and accepted there only.
        p: how likely a difference at least as large is by chance: McNemar's exact test.
    """

    set: str
    snr: float | None
    clips: int
    this: float
    other: float
    only_this: int
    only_other: int
    p: float


def compare(these: Iterable[Result], others: Iterable[Result]) -> list[Difference]:
    """Compare two evaluations by the commands that both have heard.

    Clips are the same if their manifests have the same name, call them the same and they were
    heard at the same signal-to-noise ratio; where the files are does not matter.
    """
    there = {_key(result): result for result in others if _counts(result)}
    pairs: dict[tuple[str, float | None], list[tuple[bool, bool]]] = {}
    for result in these:
        if _counts(result) and (other := there.get(_key(result))):
            both = (result.is_right_and_accepted, other.is_right_and_accepted)
            pairs.setdefault((result.set, result.snr), []).append(both)
    return [_difference(name, snr, outcomes) for (name, snr), outcomes in pairs.items()]


def _difference(name: str, snr: float | None, outcomes: list[tuple[bool, bool]]) -> Difference:
    only_this, only_other = outcomes.count((True, False)), outcomes.count((False, True))
    return Difference(
        set=name,
        snr=snr,
        clips=len(outcomes),
        this=round(sum(this for this, _ in outcomes) / len(outcomes), 5),
        other=round(sum(other for _, other in outcomes) / len(outcomes), 5),
        only_this=only_this,
        only_other=only_other,
        p=mcnemar(only_this, only_other),
    )


def _counts(result: Result) -> bool:
    return result.kind == "command" and result.error is None


def _key(result: Result) -> tuple[str, str, float | None]:
    return result.set, result.file, result.snr
