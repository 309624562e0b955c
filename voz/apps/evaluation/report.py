"""An evaluation as JSON and as text. Writes and reads no file but to compare with."""

from __future__ import annotations

from collections.abc import Sequence
from importlib.util import find_spec
from pathlib import Path

import msgspec

from voz import __version__, events
from voz.apps.evaluation.comparison import AlarmDifference, Difference, compare, compare_alarms
from voz.apps.evaluation.curves import Curves, curves
from voz.apps.evaluation.operating_points import OperatingPoint
from voz.apps.evaluation.results import Result
from voz.apps.evaluation.scores import Scores, score
from voz.apps.evaluation.tables import Table, main_tables, table_text
from voz.errors import ConfigError
from voz.extras import how_to_install
from voz.files import read_json


class Evaluation(msgspec.Struct, frozen=True):
    """All that was found out, as `--json` writes it.

    Attributes:
        voz: the version.
        settings: what was asked for, by the names of the options.
        scores: figures of groups of clips.
        curves: of all sets together.
        comparison: with another evaluation; empty if there is none.
        alarm_comparison: the same of false alarms.
        operating_points: what other false alarm rates would cost; empty for other engines.
        results: of each clip.
        date: when it was made, as ISO 8601 has it.
        machine: what it was made on.
    """

    voz: str
    settings: dict[str, str]
    scores: Scores
    curves: Curves
    comparison: list[Difference]
    alarm_comparison: list[AlarmDifference]
    operating_points: list[OperatingPoint]
    results: list[Result]
    date: str = ""
    machine: str = ""


class _Saved(msgspec.Struct):
    """What a comparison needs of an earlier evaluation."""

    results: list[Result]


def require_libraries(pictures: bool) -> None:
    """Check that what counts and draws is installed, before the work and not after it.

    Args:
        pictures: whether there will be any.

    Raises:
        ConfigError: a library is missing; the message has the line that installs it.
    """
    for library in ["jiwer", *(["matplotlib"] if pictures else [])]:
        if find_spec(library) is None:
            raise ConfigError(f"{library} is not installed; {how_to_install('report')}")


def read_results(path: Path, in_noise: bool) -> list[Result]:
    """Read the results of an earlier evaluation.

    Args:
        path: what `--json` has written.
        in_noise: whether what is said in noise is to be compared, too.

    Raises:
        ConfigError: it cannot be read or is something else, or its noise is another.
    """
    results = read_json(path, _Saved, ConfigError, "name what `voz eval --json` wrote").results
    if in_noise and any(result.snr is not None and not result.noise for result in results):
        raise ConfigError(
            f"{path}: is by an older voz, which had noise only while a command was said; "
            "make it anew, or compare without --snr"
        )
    return results


def evaluate(
    results: Sequence[Result],
    settings: dict[str, str],
    others: Sequence[Result] | None = None,
    operating_points: Sequence[OperatingPoint] = (),
    made: tuple[str, str] = ("", ""),
) -> Evaluation:
    """Count everything.

    Args:
        results: of each clip.
        settings: what was asked for, for the reader.
        others: an earlier evaluation of the same clips.
        operating_points: what other false alarm rates would cost.
        made: when, and on which machine.

    Raises:
        ConfigError: the two have nothing in common that is compared.
    """
    differences = compare(results, others or [])
    alarms = compare_alarms(results, others or [])
    if others is not None and not (differences or alarms):
        raise ConfigError(
            "the evaluation to compare with has none of these commands; "
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


def to_json(evaluation: Evaluation) -> str:
    """Write an evaluation as one line of JSON."""
    return events.to_json(evaluation)


def to_text(evaluation: Evaluation) -> str:
    """Write the most important figures for the terminal."""
    tables = [table_text(table) for table in all_tables(evaluation)]
    lines = []
    if operating := evaluation.curves.operating:
        lines.append(f"area under the ROC curve    {operating.area:.3f}")
    if reliability := evaluation.curves.reliability:
        lines.append(f"expected calibration error  {reliability.expected_error:.3f}")
    return "\n\n".join([*tables, "\n".join(lines)]).rstrip()


def all_tables(evaluation: Evaluation) -> list[Table]:
    """The tables that the terminal and the page show."""
    found = evaluation
    return main_tables(
        found.scores, found.comparison, found.operating_points, found.alarm_comparison
    )
