"""An evaluation as JSON and as text, and as an HTML page with what went wrong, and its sound."""

from __future__ import annotations

import html
import io
import os
import platform
from base64 import b64encode
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from functools import lru_cache
from pathlib import Path

import msgspec

from voz import __version__
from voz.apps.evaluation.curves import Curves, curves
from voz.apps.evaluation.recognition_tasks import Task, prepared
from voz.apps.evaluation.results import Result, Understood
from voz.apps.evaluation.scores import (
    AlarmDifference,
    Difference,
    OperatingPoint,
    Scores,
    compare,
    compare_alarms,
    score,
)
from voz.apps.evaluation.tables import Table, main_tables, speaker_tables, table_text
from voz.audio import SAMPLE_RATE
from voz.errors import AudioError, ConfigError
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


ALARM_CONTEXT = 0.5
"""Sound kept before and after a false alarm, s."""

OBEYED, MISHEARD, REFUSED, UNHEARD, UNREAD = (
    "obeyed what was not said",
    "heard wrongly",
    "refused",
    "heard nothing",
    "could not be read",
)
WORST_FIRST = (OBEYED, MISHEARD, REFUSED, UNHEARD, UNREAD)


@dataclass(frozen=True)
class Failure:
    """A clip that went wrong, or a stretch of it."""

    number: int  # of the result
    what: str  # one of `WORST_FIRST`
    heard: tuple[Understood, ...]
    stretch: tuple[float, float] | None = None  # start and end, s; None for all of the clip


def failures(results: Sequence[Result]) -> list[Failure]:
    """Find what went wrong, the worst first."""
    found = [failure for n, result in enumerate(results) for failure in _failures(n, result)]
    return sorted(found, key=lambda failure: WORST_FIRST.index(failure.what))


def _failures(number: int, result: Result) -> Iterator[Failure]:
    if result.error is not None:
        yield Failure(number, UNREAD, ())
    elif result.kind in ("command", "long"):
        if not result.is_right_and_accepted:
            yield Failure(number, _what(result), result.heard, _said_at(result))
    elif result.kind == "near-miss":
        if result.obeyed:
            yield Failure(number, OBEYED, result.heard, _said_at(result))
    else:  # perhaps hours long: only what was obeyed is a failure
        for one in result.heard:
            if one.accepted:
                stretch = max(0.0, one.start - ALARM_CONTEXT), one.end + ALARM_CONTEXT
                yield Failure(number, OBEYED, (one,), stretch)


def _what(result: Result) -> str:
    if result.is_wrongly_obeyed:
        return OBEYED
    if not result.texts:
        return UNHEARD
    return REFUSED if result.is_right else MISHEARD


def _said_at(result: Result) -> tuple[float, float] | None:
    """Where a clip is in its stream, s; None if it is a recording of its own."""
    if result.start is None or result.end is None:
        return None
    return result.start, result.end


MOST_SOUNDS = 100
"""Sounds on a page; each takes some 50 kB."""

LONGEST_SOUND = 20.0
"""Longest sound of one failure, s."""


def sounds_of_failures(failed: Sequence[Failure], tasks: Sequence[Task]) -> Mapping[Failure, bytes]:
    """Return the first failures as FLAC, with the noise and the room that they were heard in.

    `tasks` has that of each result. What cannot be read is left out.
    """
    import soundfile

    heard: dict[Failure, bytes] = {}
    read = lru_cache(1)(prepared)  # successive failures may be of one long recording
    for failure in failed[:MOST_SOUNDS]:
        try:
            samples, _ = read(tasks[failure.number])
        except AudioError:
            continue
        start, end = failure.stretch or (0.0, len(samples) / SAMPLE_RATE)
        end = min(end, start + LONGEST_SOUND)
        flac = io.BytesIO()
        part = samples[int(start * SAMPLE_RATE) : int(end * SAMPLE_RATE)]
        soundfile.write(flac, part, SAMPLE_RATE, format="FLAC")
        heard[failure] = flac.getvalue()
    return heard


PAGE_STYLE = """
body { font: 15px/1.5 sans-serif; margin: 2em auto; max-width: 80em; padding: 0 1em; }
table { border-collapse: collapse; margin: 1em 0; display: block; overflow-x: auto; }
th, td { border-bottom: 1px solid #ddd; padding: 0.2em 0.7em; text-align: right;
  white-space: nowrap; }
th:first-child, td:first-child { text-align: left; white-space: pre; }
table.failed { display: table; }
table.failed th, table.failed td { text-align: left; white-space: normal; }
table.failed td:nth-child(2), table.failed th { white-space: nowrap; }
table.failed td:last-child { overflow-wrap: anywhere; }
figure { display: inline-block; margin: 1em; vertical-align: top; }
figcaption { font-weight: bold; }
svg { max-width: 100%; height: auto; }
audio { height: 2em; width: 15em; vertical-align: middle; }
"""

PAGE_NOTES = """\
Right: exactly what was said was heard, one utterance for each command. Accepted: the
robot would obey. In brackets: 95 % confidence interval, by bootstrap over the speakers; one
without width says only that all clips agree. That of false alarms is Poisson's. Out-of-nothing is
what was obeyed before, between and after what was said in a stream or in noise. The curves and the
matrix are of all sets together, without the clips in noise."""

MOST_LISTED_FAILURES = 1000
"""Failures on a page; `--json` has all."""

FAILURE_COLUMNS = ("", "what went wrong", "said", "heard (confidence)", "speaker", "where", "clip")


def to_html(
    evaluation: Evaluation, pictures: Mapping[str, str], sounds: Mapping[Failure, bytes]
) -> str:
    """Write a page that needs no other file, network or script: SVG by title, FLAC by failure."""
    made = [("voz", evaluation.voz), ("date", evaluation.date), ("machine", evaluation.machine)]
    parts = [
        "<h1>voz eval</h1>",
        _table(Table(("made by", ""), made)),
        _table(Table(("asked for", ""), list(evaluation.settings.items()))),
        f"<p>{PAGE_NOTES}</p>",
        *(_table(table) for table in all_tables(evaluation)),
        *(_figure(title, svg) for title, svg in pictures.items()),
        *(_folded("Speakers", table) for table in speaker_tables(evaluation.scores)),
        _failed(evaluation.results, sounds),
    ]
    return (
        '<!DOCTYPE html>\n<html lang="en">\n<head>\n<meta charset="utf-8">\n'
        f"<title>voz eval</title>\n<style>{PAGE_STYLE}</style>\n</head>\n<body>\n"
        + "\n".join(parts)
        + "\n</body>\n</html>\n"
    )


def _failed(results: list[Result], sounds: Mapping[Failure, bytes]) -> str:
    failed = failures(results)
    if not failed:
        return "<h2>What went wrong: nothing</h2>"
    header = "".join(f"<th>{name}</th>" for name in FAILURE_COLUMNS)
    rows = [
        _row(_described(one, results[one.number]), sounds.get(one))
        for one in failed[:MOST_LISTED_FAILURES]
    ]
    more = len(failed) - len(rows)
    return "\n".join(
        [
            f"<h2>What went wrong: {len(failed):,}</h2>",
            f'<table class="failed">\n<tr>{header}</tr>',
            *rows,
            "</table>",
            *([f"<p>And {more:,} more, which --json lists.</p>"] if more else []),
        ]
    )


def _described(failure: Failure, result: Result) -> tuple[str, ...]:
    """The texts of a row, in the order of `FAILURE_COLUMNS` after the sound."""
    heard = ", ".join(f"{one.text or '?'} ({one.confidence:.2f})" for one in failure.heard)
    noise = "" if result.snr is None else f"{result.noise}, {result.snr:g} dB"
    at = "" if failure.stretch is None else f"{failure.stretch[0]:.1f} s"
    # Results around the clips of a stream have its file as speaker and condition.
    speaker, condition = (
        "" if name == result.file else name for name in (result.speaker, result.condition)
    )
    place = ", ".join(filter(None, (condition, noise, at)))
    said = result.text or f"({result.kind})"
    return failure.what, said, result.error or heard, speaker, place, result.file


def _row(texts: Iterable[str], sound: bytes | None) -> str:
    cells = "".join(f"<td>{html.escape(text)}</td>" for text in texts)
    player = ""
    if sound is not None:
        address = f"data:audio/flac;base64,{b64encode(sound).decode()}"
        player = f'<audio controls preload="none" src="{address}"></audio>'
    return f"<tr><td>{player}</td>{cells}</tr>"


def _table(table: Table) -> str:
    header = "".join(f"<th>{html.escape(name)}</th>" for name in table.header)
    rows = "\n".join(
        "<tr>" + "".join(f"<td>{html.escape(text)}</td>" for text in row) + "</tr>"
        for row in table.rows
    )
    return f"<table>\n<tr>{header}</tr>\n{rows}\n</table>"


def _folded(title: str, table: Table) -> str:
    summary = html.escape(f"{title}: {table.header[0]}")
    return f"<details><summary>{summary}</summary>\n{_table(table)}\n</details>"


def _figure(title: str, svg: str) -> str:
    return f"<figure><figcaption>{html.escape(title)}</figcaption>\n{svg}</figure>"
