"""The figures as tables of texts. Pure."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass

from voz.apps.evaluation.scores import (
    AlarmDifference,
    AlarmScores,
    CommandScores,
    Confusion,
    Difference,
    Group,
    NearMissScores,
    OperatingPoint,
    Scores,
)
from voz.apps.evaluation.statistics import AlarmRate, Estimate

TABLE_INDENT = "  "

MAX_CONFUSIONS = 10
"""Most rows of misheard commands; the others are summed up in the last one."""

MAX_CONFUSED_SPEAKERS = 6
"""Most speakers with a column of their own; the others share the last one."""


@dataclass(frozen=True)
class Table:
    """A table of texts."""

    header: tuple[str, ...]
    rows: Sequence[tuple[str, ...]]  # a text for each column; the first names the row


def main_tables(
    scores: Scores,
    differences: Sequence[Difference],
    operating_points: Sequence[OperatingPoint] = (),
    alarms: Sequence[AlarmDifference] = (),
) -> list[Table]:
    """Make the tables of sets, conditions, noise, alarms, operating points and comparisons.

    Beside them, what commands were misheard as.
    """
    noises = {score.group.noise for score in scores.commands if score.group.noise}
    by = ("all", "condition", "snr", *(["noise"] if len(noises) > 1 else []))
    tables = [
        commands_table([s for s in scores.commands if s.group.by in by]),
        confusion_table(scores.confusions),
        near_miss_table([s for s in scores.near_misses if s.group.by in by]),
        alarm_table([s for s in scores.alarms if s.group.by in by]),
        operating_point_table(operating_points),
        comparison_table(differences),
        alarm_comparison_table(alarms),
    ]
    return [table for table in tables if table.rows]


def speaker_tables(scores: Scores) -> list[Table]:
    """Make the tables of single speakers, the worst first."""
    commands = [s for s in scores.commands if s.group.by == "speaker"]
    near_misses = [s for s in scores.near_misses if s.group.by == "speaker"]
    commands.sort(key=lambda s: s.right_and_accepted.value)
    near_misses.sort(key=lambda s: -s.let_through.value)
    tables = [commands_table(commands), near_miss_table(near_misses)]
    return [table for table in tables if table.rows]


def commands_table(scores: Iterable[CommandScores]) -> Table:
    """Show recordings of commands."""
    return _table(
        {
            "commands": _label(s.group),
            "clips": str(s.clips),
            "speakers": str(s.speakers),
            "right": estimate_text(s.right),
            "right and accepted": estimate_text(s.right_and_accepted),
            "word errors": estimate_text(s.word_error_rate),
            "refused": estimate_text(s.refused),
            "wrongly obeyed": estimate_text(s.wrongly_obeyed),
            "CPU ms": f"{s.cpu_ms:.1f}",
        }
        for s in scores
    )


def near_miss_table(scores: Iterable[NearMissScores]) -> Table:
    """Show speech that is no command."""
    return _table(
        {
            "near-misses": _label(s.group),
            "clips": str(s.clips),
            "speakers": str(s.speakers),
            "let through": estimate_text(s.let_through),
        }
        for s in scores
    )


def confusion_table(confusions: Sequence[Confusion]) -> Table:
    """Show the most frequent confusions, and the speakers that have most of them."""
    totals: Counter[str] = Counter()
    for each in confusions:
        totals.update(each.speakers)
    speakers = [speaker for speaker, _ in totals.most_common(MAX_CONFUSED_SPEAKERS)]
    others = len(totals) > len(speakers)

    def row(name: str, counts: Mapping[str, int]) -> tuple[str, ...]:
        of = [counts.get(speaker, 0) for speaker in speakers]
        everyone = sum(counts.values())
        of += [everyone - sum(of)] if others else []
        return name, str(everyone), *(str(count or "") for count in of)

    rows = [row(f"{c.said} {c.outcome}", c.speakers) for c in confusions[:MAX_CONFUSIONS]]
    if rest := confusions[MAX_CONFUSIONS:]:
        counts: Counter[str] = Counter()
        for each in rest:
            counts.update(each.speakers)
        rows.append(row(f"{len(rest)} more", counts))
    return Table(("misheard", "clips", *speakers, *(["others"] if others else [])), rows)


def alarm_table(scores: Iterable[AlarmScores]) -> Table:
    """Show running speech, noise, and what is between commands."""
    return _table(
        {
            "talk and noise": _alarm_label(s.group),
            "false alarms": alarm_rate_text(s.rate),
            "obeyed": ", ".join(f"{command} {number}" for command, number in s.commands.items()),
        }
        for s in scores
    )


def operating_point_table(operating_points: Iterable[OperatingPoint]) -> Table:
    """Show what fewer or more false alarms would cost."""
    return _table(
        {
            "false_alarms_per_hour": f"{p.false_alarms_per_hour:g}",
            "threshold": f"{p.threshold:.3f}",
            "missed": "" if p.missed is None else f"{p.missed:.3f}",
            "near-misses": "" if p.let_through is None else f"{p.let_through:.3f}",
            "alarms in talk": "" if p.talk is None else alarm_rate_text(p.talk),
        }
        for p in operating_points
    )


def comparison_table(differences: Iterable[Difference]) -> Table:
    """Show two evaluations side by side."""
    return _table(
        {
            "right and accepted": d.set if d.snr is None else f"{TABLE_INDENT}{d.snr:g} dB",
            "clips": str(d.clips),
            "here": f"{d.this:.3f}",
            "there": f"{d.other:.3f}",
            "difference": f"{d.this - d.other:+.3f}",
            "only here": str(d.only_this),
            "only there": str(d.only_other),
            "p": f"{d.p:.2g}",
        }
        for d in differences
    )


def alarm_comparison_table(differences: Iterable[AlarmDifference]) -> Table:
    """Show the false alarms of two evaluations side by side."""
    return _table(
        {
            "false alarms": f"{d.set}, {d.kind}" + ("" if d.snr is None else f", {d.snr:g} dB"),
            "here": alarm_rate_text(d.this),
            "there": alarm_rate_text(d.other),
        }
        for d in differences
    )


def table_text(table: Table) -> str:
    """Align a table for the terminal: names to the left, figures to the right."""
    lines = [table.header, *table.rows]
    widths = [max(map(len, column)) for column in zip(*lines, strict=True)]
    return "\n".join(
        TABLE_INDENT.join(
            [name.ljust(widths[0])]
            + [text.rjust(width) for text, width in zip(texts, widths[1:], strict=True)]
        )
        for name, *texts in lines
    )


def estimate_text(figure: Estimate, digits: int = 3) -> str:
    """Write a figure with its interval, which has a digit less: `0.943 (0.92-0.96)`."""
    low, high = (f"{end:.{digits - 1}f}" for end in (figure.low, figure.high))
    return f"{figure.value:.{digits}f} ({low}-{high})"


def alarm_rate_text(rate: AlarmRate) -> str:
    """Write alarms with how long they come from: `0 in 0.6 h (0 to 6.1 per hour)`."""
    low, high = _short(rate.per_hour.low), _short(rate.per_hour.high)
    return f"{rate.alarms} in {_short(rate.hours)} h ({low} to {high} per hour)"


def _table(rows: Iterable[Mapping[str, str]]) -> Table:
    """Make a table of rows by the names of their columns."""
    rows = list(rows)
    return Table(tuple(rows[0]) if rows else (), [tuple(row.values()) for row in rows])


def _short(figure: float) -> str:
    return f"{figure:.2g}" if figure < 10 else f"{figure:.0f}"


def _label(group: Group) -> str:
    if group.by != "all":
        return TABLE_INDENT + group.name
    return group.set if group.kind in ("command", "near-miss") else f"{group.set}, {group.kind}"


def _alarm_label(group: Group) -> str:
    """Name a group of alarms; those in noise have no whole set above them."""
    if group.snr is None:
        return _label(group)
    return f"{group.set}, {group.kind}, {group.name}"
