"""Compares two evaluations of the same clips. Pure."""

from __future__ import annotations

from collections.abc import Collection, Iterable, Iterator

import msgspec

from voz.apps.evaluation.results import OUT_OF_NOTHING, Result, ScoredKind
from voz.apps.evaluation.scores import alarms_in
from voz.apps.evaluation.statistics import AlarmRate, mcnemar


class Difference(msgspec.Struct, frozen=True):
    """A set of commands, heard in two ways."""

    set: str
    snr: float | None  # dB; None without added noise
    clips: int  # heard in both
    this: float  # share right and accepted here
    other: float  # the same in the other evaluation
    only_this: int  # clips right and accepted only here
    only_other: int  # clips right and accepted only there
    p: float  # of McNemar's exact test


class AlarmDifference(msgspec.Struct, frozen=True):
    """Sound that should move nothing, heard in two ways."""

    set: str
    kind: ScoredKind
    snr: float | None  # dB; None without added noise
    this: AlarmRate
    other: AlarmRate


def compare(these: Iterable[Result], others: Iterable[Result]) -> list[Difference]:
    """Compare two evaluations by the commands that both have heard.

    Clips are the same if set, file and noise have the same names, wherever the files are.
    """
    pairs: dict[tuple[str, float | None], list[tuple[bool, bool]]] = {}
    for result, other in _pairs(these, others, ("command",)):
        both = (result.is_right_and_accepted, other.is_right_and_accepted)
        pairs.setdefault((result.set, result.snr), []).append(both)
    return [_difference(name, snr, outcomes) for (name, snr), outcomes in pairs.items()]


def compare_alarms(these: Iterable[Result], others: Iterable[Result]) -> list[AlarmDifference]:
    """Compare two evaluations by the false alarms in the sound that both have heard."""
    pairs: dict[tuple[str, ScoredKind, float | None], list[tuple[Result, Result]]] = {}
    for result, other in _pairs(these, others, ("talk", "noise", OUT_OF_NOTHING)):
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


def _pairs(
    these: Iterable[Result], others: Iterable[Result], kinds: Collection[str]
) -> Iterator[tuple[Result, Result]]:
    there = {_key(result): result for result in others if result.error is None}
    for result in these:
        other = there.get(_key(result))
        if result.kind in kinds and result.error is None and other:
            yield result, other


def _key(result: Result) -> tuple[object, ...]:
    clip = (result.set, result.file, result.kind, result.start)
    return *clip, result.snr, result.noise
