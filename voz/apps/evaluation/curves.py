"""Curves over the confidence, and which command is taken for which. Pure."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterable, Sequence

import msgspec

from voz.apps.evaluation.results import Result

RELIABILITY_BINS = 10
"""Each is a tenth of the confidences wide."""

TAKEN_FOR_NOTHING = "(nothing)"
TAKEN_FOR_REFUSED = "(refused)"


class CurvePoint(msgspec.Struct, frozen=True):
    """What a threshold would do."""

    threshold: float
    hits: float  # share of the commands heard right that would be obeyed
    false_alarms: float  # share of the near-misses that would be obeyed


class OperatingCurve(msgspec.Struct, frozen=True):
    """How well confidences tell commands from near-misses: the points of the ROC and DET curves."""

    points: list[CurvePoint]  # one for each confidence, the highest first
    area: float  # under the ROC curve


class ReliabilityBin(msgspec.Struct, frozen=True):
    """Utterances that are about equally sure."""

    confidence: float  # mean
    right: float  # share that was said
    utterances: int  # how many


class Reliability(msgspec.Struct, frozen=True):
    """Whether utterances with confidence 0.8 are right in 8 of 10."""

    bins: list[ReliabilityBin]  # those with utterances, by confidence
    expected_error: float  # expected calibration error


class ConfusionMatrix(msgspec.Struct, frozen=True):
    """Which command was taken for which."""

    said: list[str]  # the rows
    heard: list[str]  # the columns: commands, then `(refused)` and `(nothing)`
    counts: list[list[int]]  # clips, a list for each row


class Curves(msgspec.Struct, frozen=True):
    """What the pictures show; None where there is nothing to show. Without the clips in noise."""

    operating: OperatingCurve | None
    reliability: Reliability | None
    confusion: ConfusionMatrix | None


def curves(results: Iterable[Result]) -> Curves:
    """Compute all curves; clips with an error or with added noise are left out."""
    clean = [r for r in results if r.error is None and r.snr is None]
    commands = [r for r in clean if r.kind == "command"]
    sure = [max(u.confidence for u in r.heard if u.text) for r in commands if r.is_right]
    near_misses = [
        max((u.confidence for u in r.heard if u.text), default=0.0)
        for r in clean
        if r.kind == "near-miss"
    ]
    labeled = [
        (utterance.confidence, r.kind == "command" and utterance.text == r.text)
        for r in clean
        if r.kind != "long"  # its utterances cannot be assigned to its commands
        for utterance in r.heard
        if utterance.text
    ]
    return Curves(
        operating=operating_curve(sure, near_misses) if sure and near_misses else None,
        reliability=reliability(labeled) if labeled else None,
        confusion=confusion([(r.text, taken_for(r)) for r in commands]) if commands else None,
    )


def operating_curve(commands: Sequence[float], near_misses: Sequence[float]) -> OperatingCurve:
    """Sweep the threshold over all confidences.

    Args:
        commands: confidences of commands that were heard right.
        near_misses: the highest confidence in each near-miss; 0 if nothing was heard.
    """
    points = []
    ours, others = Counter(commands), Counter(near_misses)
    hits = false_alarms = area = 0.0
    for threshold in sorted(ours | others, reverse=True):
        width = others[threshold] / len(near_misses)
        area += width * (hits + ours[threshold] / len(commands) / 2)
        hits += ours[threshold] / len(commands)
        false_alarms += width
        points.append(CurvePoint(threshold, round(hits, 5), round(false_alarms, 5)))
    return OperatingCurve(points, round(area, 5))


def reliability(utterances: Sequence[tuple[float, bool]]) -> Reliability:
    """Compare confidences, 0 to 1, with how often they are right; at least one utterance."""
    bins: list[list[tuple[float, bool]]] = [[] for _ in range(RELIABILITY_BINS)]
    for confidence, right in utterances:
        bins[min(int(confidence * RELIABILITY_BINS), RELIABILITY_BINS - 1)].append(
            (confidence, right)
        )
    filled = [_bin(members) for members in bins if members]
    off = sum(abs(b.confidence - b.right) * b.utterances for b in filled)
    return Reliability(filled, round(off / len(utterances), 5))


def confusion(pairs: Sequence[tuple[str, str]]) -> ConfusionMatrix:
    """Count pairs of what was said and what it was taken for (see `taken_for`)."""
    counts = Counter(pairs)
    said = sorted({pair[0] for pair in pairs})
    others = {pair[1] for pair in pairs} - set(said) - {TAKEN_FOR_REFUSED, TAKEN_FOR_NOTHING}
    heard = [*said, *sorted(others), TAKEN_FOR_REFUSED, TAKEN_FOR_NOTHING]
    return ConfusionMatrix(said, heard, [[counts[row, column] for column in heard] for row in said])


def taken_for(result: Result) -> str:
    """Return the first command that a clip would make the robot obey, or why there is none."""
    if result.obeyed:
        return result.obeyed[0]
    return TAKEN_FOR_REFUSED if result.is_refused else TAKEN_FOR_NOTHING


def _bin(members: list[tuple[float, bool]]) -> ReliabilityBin:
    count = len(members)
    confidence = sum(confidence for confidence, _ in members) / count
    return ReliabilityBin(
        round(confidence, 5), round(sum(right for _, right in members) / count, 5), count
    )
