"""Two evaluations of the same clips: which recognizes more, and is that by chance? Pure."""

from __future__ import annotations

from collections.abc import Collection, Iterable, Iterator

import msgspec

from voz.apps.evaluation.results import OUT_OF_NOTHING, Result, ScoredKind
from voz.apps.evaluation.scores import alarms_in
from voz.apps.evaluation.statistics import AlarmRate, mcnemar


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


class AlarmDifference(msgspec.Struct, frozen=True):
    """Sound that should move nothing, heard in two ways.

    Attributes:
        set: the manifest it comes from.
        kind: what it is.
        snr: at which signal-to-noise ratio, dB; None is without added noise.
        this: what would be obeyed here.
        other: the same there.
    """

    set: str
    kind: ScoredKind
    snr: float | None
    this: AlarmRate
    other: AlarmRate


def compare(these: Iterable[Result], others: Iterable[Result]) -> list[Difference]:
    """Compare two evaluations by the commands that both have heard.

    Clips are the same if their manifests have the same name, call them the same and they were
    heard in the same noise; where the files are does not matter.
    """
    pairs: dict[tuple[str, float | None], list[tuple[bool, bool]]] = {}
    for result, other in _both(these, others, ("command",)):
        both = (result.is_right_and_accepted, other.is_right_and_accepted)
        pairs.setdefault((result.set, result.snr), []).append(both)
    return [_difference(name, snr, outcomes) for (name, snr), outcomes in pairs.items()]


def compare_alarms(these: Iterable[Result], others: Iterable[Result]) -> list[AlarmDifference]:
    """Compare two evaluations by what both have heard that should move nothing while it goes on."""
    pairs: dict[tuple[str, ScoredKind, float | None], list[tuple[Result, Result]]] = {}
    for result, other in _both(these, others, ("talk", "noise", OUT_OF_NOTHING)):
        pairs.setdefault((result.set, result.kind, result.snr), []).append((result, other))
    return [
        AlarmDifference(*group, alarms_in(r for r, _ in pair), alarms_in(o for _, o in pair))
        for group, pair in pairs.items()
    ]


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


def _both(
    these: Iterable[Result], others: Iterable[Result], kinds: Collection[str]
) -> Iterator[tuple[Result, Result]]:
    """Pair what both have heard."""
    there = {_key(result): result for result in others if result.error is None}
    for result in these:
        other = there.get(_key(result))
        if result.kind in kinds and result.error is None and other:
            yield result, other


def _key(result: Result) -> tuple[object, ...]:
    clip = (result.set, result.file, result.kind, result.start)
    return *clip, result.snr, result.noise
