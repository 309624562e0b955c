"""The curves as pictures, SVG and PNG. Needs matplotlib."""

from __future__ import annotations

import re
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from io import BytesIO, StringIO
from statistics import NormalDist
from typing import Any, TypeVar

from matplotlib import rc_context
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from voz.apps.evaluation.curves import ConfusionMatrix, Curves, OperatingCurve, Reliability
from voz.apps.evaluation.scores import CommandScores

Data = TypeVar("Data")

PLOT_STYLE: Any = {  # its type would be a literal of all names that matplotlib knows
    "font.size": 9,
    "axes.grid": True,
    "grid.alpha": 0.3,
    "svg.hashsalt": "voz",  # the same figures give the same file
    "text.parse_math": False,  # a text with $ in it is no formula
}

DET_TICKS = (0.001, 0.01, 0.05, 0.1, 0.2, 0.4, 0.6, 0.8, 0.9, 0.95, 0.99)
"""Rates at the ticks of both axes."""

NO_NOISE_LABEL = "quiet"

PNG_DOTS_PER_INCH = 200

CELL_INCHES = 0.42
"""Width and height of a cell of the confusion matrix."""


@dataclass(frozen=True)
class Plot:
    """A picture: as an SVG element, and as PNG."""

    svg: str
    png: bytes


def pictures(curves: Curves, commands: Sequence[CommandScores]) -> dict[str, Plot]:
    """Draw what there is to draw; returns pictures by their titles."""
    drawn = {}
    if curves.operating:
        drawn["Commands and near-misses (ROC)"] = _picture(_draw_roc, curves.operating)
        drawn["Missed and let through (DET)"] = _picture(_draw_det, curves.operating)
    if curves.reliability:
        drawn["Confidence and share right"] = _picture(_draw_reliability, curves.reliability)
    if len({s.group.snr for s in commands if s.group.by == "snr"}) > 1:
        drawn["Commands in noise"] = _picture(_draw_accuracy_against_noise, commands)
    if curves.confusion:
        drawn["What commands were taken for"] = confusion(curves.confusion)
    return drawn


def _draw_roc(axes: Axes, curve: OperatingCurve) -> None:
    """Draw what is let through against what is obeyed, over all thresholds."""
    axes.plot([0, 1], [0, 1], color="gray", linestyle=":", linewidth=1)
    axes.step(
        [0.0, *(point.false_alarms for point in curve.points)],
        [0.0, *(point.hits for point in curve.points)],
        where="post",
    )
    axes.set(
        xlabel="near-misses let through",
        ylabel="commands heard right that are accepted",
        title=f"area under the curve {curve.area:.3f}",
        xlim=(-0.01, 1.01),
        ylim=(-0.01, 1.01),
    )


def _draw_det(axes: Axes, curve: OperatingCurve) -> None:
    """Draw missed against let through, on axes where normal distributions give a straight line.

    Rates beyond the axes, as 0, are drawn at their ends.
    """
    scale = NormalDist().inv_cdf
    lowest, highest = DET_TICKS[0], DET_TICKS[-1]

    def at(rate: float) -> float:
        return scale(min(max(rate, lowest), highest))

    axes.plot(
        [at(point.false_alarms) for point in curve.points],
        [at(1 - point.hits) for point in curve.points],
    )
    ticks, labels = [scale(rate) for rate in DET_TICKS], [f"{rate:g}" for rate in DET_TICKS]
    axes.set_xticks(ticks, labels, rotation=60)
    axes.set_yticks(ticks, labels)
    limits = (scale(lowest) - 0.1, scale(highest) + 0.1)
    axes.set(
        xlabel="near-misses let through",
        ylabel="commands heard right that are refused",
        title="nearer to the lower left corner is better",
        xlim=limits,
        ylim=limits,
    )


def _draw_reliability(axes: Axes, curve: Reliability) -> None:
    """Draw how often utterances of each confidence are right, and how many they are."""
    confidences = [b.confidence for b in curve.bins]
    axes.plot([0, 1], [0, 1], color="gray", linestyle=":", linewidth=1)
    axes.plot(confidences, [b.right for b in curve.bins], marker="o")
    for b in curve.bins:
        axes.annotate(
            str(b.utterances),
            (b.confidence, b.right),
            xytext=(0, 6 if b.right > b.confidence else -12),  # away from the diagonal
            textcoords="offset points",
            ha="center",
            fontsize=7,
        )
    axes.set(
        xlabel="confidence",
        ylabel="share right (with the number of utterances)",
        title=f"expected calibration error {curve.expected_error:.3f}",
        xlim=(-0.02, 1.04),
        ylim=(-0.08, 1.08),
    )


def _draw_accuracy_against_noise(axes: Axes, commands: Sequence[CommandScores]) -> None:
    """Draw the share of commands right and accepted over the ratio, a line for each noise."""
    lines = noise_lines(commands)
    found = {score.group.snr for scores in lines.values() for score in scores}
    places = sorted(found - {None}, key=lambda snr: -(snr or 0))
    places.insert(0, None)
    for name, scores in lines.items():
        values = [score.right_and_accepted for score in scores]
        axes.errorbar(
            [places.index(score.group.snr) for score in scores],
            [v.value for v in values],
            yerr=([v.value - v.low for v in values], [v.high - v.value for v in values]),
            marker="o" if scores[0].group.noise else "s",
            capsize=3,
            label=name,
        )
    axes.set_xticks(range(len(places)), [NO_NOISE_LABEL, *(f"{snr:g}" for snr in places[1:])])
    axes.set(xlabel="signal-to-noise ratio, dB", ylabel="right and accepted", ylim=(-0.02, 1.02))
    axes.legend(loc="lower left", fontsize=7)


def noise_lines(commands: Sequence[CommandScores]) -> dict[str, list[CommandScores]]:
    """Return the scores on each line of that picture; several sets are named in its label."""
    chosen = [
        score.group
        for score in commands
        if score.group.kind == "command" and score.group.by in ("all", "noise")
    ]
    several = len({group.set for group in chosen}) > 1
    lines: dict[str, list[CommandScores]] = {}
    for score in commands:
        if score.group in chosen:
            noise = score.group.noise or NO_NOISE_LABEL
            name = f"{score.group.set}, {noise}" if several else noise
            lines.setdefault(name, []).append(score)
    return lines


def confusion(matrix: ConfusionMatrix) -> Plot:
    """Draw how many clips of each command were taken for which."""
    width = 2 + CELL_INCHES * len(matrix.heard)
    return _picture(_draw_confusion, matrix, width, 1.7 + CELL_INCHES * len(matrix.said))


def _draw_confusion(axes: Axes, matrix: ConfusionMatrix) -> None:
    shares = [[count / sum(row) for count in row] for row in matrix.counts]
    axes.imshow(shares, cmap="Blues", vmin=0, vmax=1, aspect="auto")
    axes.grid(visible=False)
    axes.set_xticks(range(len(matrix.heard)), matrix.heard, rotation=45, ha="right")
    axes.set_yticks(range(len(matrix.said)), matrix.said)
    axes.set(xlabel="taken for", ylabel="said")
    for row, counts in enumerate(matrix.counts):
        for column, count in enumerate(counts):
            if count:
                color = "white" if shares[row][column] > 0.5 else "black"
                axes.text(column, row, str(count), ha="center", va="center", color=color)


def _picture(
    draw: Callable[[Axes, Data], None], data: Data, width: float = 4.4, height: float = 4.0
) -> Plot:
    """Draw on a figure of so many inches."""
    with rc_context(PLOT_STYLE):
        figure = Figure(figsize=(width, height), layout="constrained")
        draw(figure.subplots(), data)
        file = StringIO()
        nothing = dict.fromkeys(("Creator", "Date", "Format", "Type"))
        figure.savefig(file, format="svg", metadata=nothing)
        png = BytesIO()
        figure.savefig(png, format="png", dpi=PNG_DOTS_PER_INCH, metadata={"Software": None})
    svg = file.getvalue()
    # Without the XML declaration and the document type, which has a URL.
    svg = re.sub(r"<!--.*?-->\n?", "", svg[svg.index("<svg") :], flags=re.DOTALL)
    return Plot(svg, png.getvalue())
