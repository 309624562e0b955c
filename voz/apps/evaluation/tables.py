"""The figures as tables of texts. Pure."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from voz.apps.evaluation.comparison import AlarmDifference, Difference
from voz.apps.evaluation.operating_points import OperatingPoint
from voz.apps.evaluation.scores import AlarmScores, CommandScores, Group, NearMissScores, Scores
from voz.apps.evaluation.statistics import AlarmRate, Estimate

TABLE_INDENT = "  "


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
    """Make the tables of sets, conditions, noise, alarms, operating points and comparisons."""
    noises = {score.group.noise for score in scores.commands if score.group.noise}
    by = ("all", "condition", "snr", *(["noise"] if len(noises) > 1 else []))
    tables = [
        commands_table([s for s in scores.commands if s.group.by in by]),
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


def commands_table(scores: Sequence[CommandScores]) -> Table:
    """Show recordings of commands."""
    header = (
        "commands",
        "clips",
        "speakers",
        "right",
        "right and accepted",
        "word errors",
        "refused",
        "wrongly obeyed",
        "CPU ms",
    )
    rows = [
        (
            _label(s.group),
            str(s.clips),
            str(s.speakers),
            estimate_text(s.right),
            estimate_text(s.right_and_accepted),
            estimate_text(s.word_error_rate),
            estimate_text(s.refused),
            estimate_text(s.wrongly_obeyed),
            f"{s.cpu_ms:.1f}",
        )
        for s in scores
    ]
    return Table(header, rows)


def near_miss_table(scores: Sequence[NearMissScores]) -> Table:
    """Show speech that is no command."""
    rows = [
        (_label(s.group), str(s.clips), str(s.speakers), estimate_text(s.let_through))
        for s in scores
    ]
    return Table(("near-misses", "clips", "speakers", "let through"), rows)


def alarm_table(scores: Sequence[AlarmScores]) -> Table:
    """Show running speech, noise, and what is between commands."""
    rows = [
        (
            _alarm_label(s.group),
            alarm_rate_text(s.rate),
            ", ".join(f"{command} {number}" for command, number in s.commands.items()),
        )
        for s in scores
    ]
    return Table(("talk and noise", "false alarms", "obeyed"), rows)


def operating_point_table(operating_points: Sequence[OperatingPoint]) -> Table:
    """Show what fewer or more false alarms would cost."""
    header = ("false_alarms_per_hour", "threshold", "missed", "near-misses", "alarms in talk")
    rows = [
        (
            f"{p.false_alarms_per_hour:g}",
            f"{p.threshold:.3f}",
            *("" if v is None else f"{v:.3f}" for v in (p.missed, p.let_through)),
            "" if p.talk is None else alarm_rate_text(p.talk),
        )
        for p in operating_points
    ]
    return Table(header, rows)


def comparison_table(differences: Sequence[Difference]) -> Table:
    """Show two evaluations side by side."""
    header = (
        "right and accepted",
        "clips",
        "here",
        "there",
        "difference",
        "only here",
        "only there",
        "p",
    )
    rows = [
        (
            d.set if d.snr is None else f"{TABLE_INDENT}{d.snr:g} dB",
            str(d.clips),
            f"{d.this:.3f}",
            f"{d.other:.3f}",
            f"{d.this - d.other:+.3f}",
            str(d.only_this),
            str(d.only_other),
            f"{d.p:.2g}",
        )
        for d in differences
    ]
    return Table(header, rows)


def alarm_comparison_table(differences: Sequence[AlarmDifference]) -> Table:
    """Show the false alarms of two evaluations side by side."""
    rows = [
        (
            f"{d.set}, {d.kind}" if d.snr is None else f"{d.set}, {d.kind}, {d.snr:g} dB",
            alarm_rate_text(d.this),
            alarm_rate_text(d.other),
        )
        for d in differences
    ]
    return Table(("false alarms", "here", "there"), rows)


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
