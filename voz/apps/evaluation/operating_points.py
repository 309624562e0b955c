"""The commands missed at other settings of `false_alarms_per_hour`. Pure."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence

import msgspec
from msgspec.structs import replace

from voz.apps.evaluation.results import Result, Understood
from voz.apps.evaluation.scores import alarms_in
from voz.apps.evaluation.statistics import AlarmRate
from voz.recognition.confidence import Model, alarm_rates_near
from voz.recognition.thresholds import thresholds
from voz.settings import Recognition


class OperatingPoint(msgspec.Struct, frozen=True):
    """One rate of false alarms that may be asked for, and what it costs."""

    false_alarms_per_hour: float  # the setting
    threshold: float  # that most commands need
    missed: float | None  # share of the commands not right and accepted; None without any
    let_through: float | None  # share of the near-misses obeyed; None without any
    talk: AlarmRate | None  # false alarms in talk; None without any


def operating_points(
    results: Iterable[Result], model: Model, settings: Recognition, commands: Iterable[str]
) -> list[OperatingPoint]:
    """Compute what would be obeyed at several rates of false alarms.

    Args:
        results: what voz itself made of clips; those in added noise are left out.
        model: has the threshold for each setting.
        settings: which commands must not be missed.
        commands: all sentences.
    """
    clean = [r for r in results if r.snr is None and r.error is None]
    found = []
    for alarms in alarm_rates_near(model.default_alarm_rate):
        asked = replace(settings, threshold=None, false_alarms_per_hour=alarms)
        needed = thresholds(model, asked, commands)
        judged = [replace(r, heard=tuple(_judged(u, needed) for u in r.heard)) for r in clean]
        found.append(_operating_point(alarms, max(needed.values()), judged))
    return found


def _judged(heard: Understood, needed: Mapping[str, float]) -> Understood:
    accepted = heard.text in needed and heard.confidence >= needed[heard.text]
    return replace(heard, accepted=accepted)


def _operating_point(alarms: float, threshold: float, results: Sequence[Result]) -> OperatingPoint:
    commands = [not r.is_right_and_accepted for r in results if r.kind == "command"]
    near_misses = [bool(r.obeyed) for r in results if r.kind == "near-miss"]
    talk = [r for r in results if r.kind == "talk"]
    return OperatingPoint(
        alarms,
        round(threshold, 3),
        _mean(commands),
        _mean(near_misses),
        alarms_in(talk) if talk else None,
    )


def _mean(values: Sequence[bool]) -> float | None:
    return round(sum(values) / len(values), 4) if values else None
