"""An evaluation as JSON and as text."""

from __future__ import annotations

import os
import platform
from collections.abc import Sequence
from pathlib import Path

import msgspec

from voz import __version__
from voz.apps.evaluation.curves import Curves, curves
from voz.apps.evaluation.results import Result
from voz.apps.evaluation.scores import (
    AlarmDifference,
    Difference,
    OperatingPoint,
    Scores,
    compare,
    compare_alarms,
    score,
)
from voz.apps.evaluation.tables import Table, main_tables, table_text
from voz.errors import ConfigError
from voz.files import read_json

CPUINFO = Path("/proc/cpuinfo")
BOARD_MODEL = Path("/proc/device-tree/model")
"""The model of a small computer, as `Raspberry Pi 5 Model B Rev 1.0`."""


def machine() -> str:
    """The processor, its number of cores and the version of Python."""
    return f"{_processor()}, {os.cpu_count()} cores, Python {platform.python_version()}"


def _processor() -> str:
    if BOARD_MODEL.exists():
        return BOARD_MODEL.read_text().rstrip("\0\n")
    info = CPUINFO.read_text() if CPUINFO.exists() else ""
    models = [line.partition(": ")[2] for line in info.splitlines() if "model name" in line]
    return models[0] if models else platform.machine()


class Evaluation(msgspec.Struct, frozen=True):
    """All that was found out, as `--json` writes it."""

    voz: str  # version
    settings: dict[str, str]  # by the names of the options
    scores: Scores
    curves: Curves  # of all sets together
    comparison: list[Difference]  # with another evaluation
    alarm_comparison: list[AlarmDifference]
    operating_points: list[OperatingPoint]  # empty for other engines
    results: list[Result]
    date: str = ""  # ISO 8601
    machine: str = ""


class _Saved(msgspec.Struct):
    """What a comparison needs of an earlier evaluation."""

    results: list[Result]


def read_results(path: Path) -> list[Result]:
    """Read the results that an earlier evaluation wrote by `--json`; raises ConfigError."""
    return read_json(path, _Saved, ConfigError, "name what `voz eval --json` wrote").results


def evaluate(
    results: Sequence[Result],
    settings: dict[str, str],
    others: Sequence[Result] | None = None,
    operating_points: Sequence[OperatingPoint] = (),
    made: tuple[str, str] = ("", ""),
) -> Evaluation:
    """Count everything; `made` is when, and on which machine.

    Raises:
        ConfigError: it has no clip in common with the others, an earlier evaluation.
    """
    differences = compare(results, others or [])
    alarms = compare_alarms(results, others or [])
    if others is not None and not (differences or alarms):
        raise ConfigError(
            "--compare: the other evaluation has none of these commands; "
            "make it from the same manifests"
        )
    return Evaluation(
        voz=__version__,
        settings=settings,
        scores=score(results),
        curves=curves(results),
        comparison=differences,
        alarm_comparison=alarms,
        operating_points=list(operating_points),
        results=list(results),
        date=made[0],
        machine=made[1],
    )


def to_text(evaluation: Evaluation) -> str:
    """Write the main figures for the terminal."""
    tables = [table_text(table) for table in all_tables(evaluation)]
    lines = []
    if operating := evaluation.curves.operating:
        lines.append(f"area under the ROC curve    {operating.area:.3f}")
    if reliability := evaluation.curves.reliability:
        lines.append(f"expected calibration error  {reliability.expected_error:.3f}")
    return "\n\n".join([*tables, "\n".join(lines)]).rstrip()


def all_tables(evaluation: Evaluation) -> list[Table]:
    """Return the tables that the terminal and the page show."""
    found = evaluation
    return main_tables(
        found.scores, found.comparison, found.operating_points, found.alarm_comparison
    )
