"""Draws how alike commands sound. Needs matplotlib."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from itertools import permutations
from pathlib import Path
from typing import TYPE_CHECKING

from voz.errors import VozError
from voz.extras import how_to_install
from voz.language.phone_distances import PhoneDistances
from voz.language.similarity import find_similar
from voz.language.similarity_report import WARNING_SIMILARITY

if TYPE_CHECKING:
    from matplotlib.figure import Figure

MAX_PICTURED_COMMANDS = 60
"""More are not readable."""


def draw_matrix(
    commands: Sequence[str],
    pronunciations: Mapping[str, Sequence[str]],
    path: Path,
    distances: PhoneDistances | None = None,
) -> None:
    """Draw how alike all commands sound, as PNG or SVG; raises VozError."""
    if path.suffix.lower() not in (".png", ".svg"):
        raise VozError(f"{path}: not a picture name; end it with .png or .svg")
    try:
        from matplotlib.figure import Figure
    except ImportError:
        raise VozError(f"matplotlib is not installed; {how_to_install('report')}") from None
    figure = Figure(figsize=(3 + len(commands) / 2, 2 + len(commands) / 2), layout="constrained")
    _draw_matrix(figure, commands, _matrix(commands, pronunciations, distances))
    try:
        figure.savefig(path, dpi=120)
    except OSError as error:
        raise VozError(f"{path}: cannot be written ({error.strerror})") from None


def _draw_matrix(figure: Figure, commands: Sequence[str], cells: list[list[float]]) -> None:
    axes = figure.add_subplot()
    # Two commands are rarely under 0.4: with colors from 0 on all would be the same red.
    image = axes.imshow(cells, cmap="YlOrRd", vmin=0.4, vmax=1.0)
    figure.colorbar(image, shrink=0.8)
    places = range(len(commands))
    axes.set_xticks(places, commands, rotation=45, ha="right", rotation_mode="anchor")
    axes.set_yticks(places, commands)
    for row, column in permutations(places, 2):
        alike = cells[row][column]
        color, weight = ("white", "bold") if alike >= WARNING_SIMILARITY else ("black", "normal")
        axes.text(
            column, row, f"{alike:.2f}", ha="center", va="center", fontsize=8,
            color=color, weight=weight,
        )  # fmt: skip
    axes.set_title("How alike the commands sound; bold: worth a warning")


def _matrix(
    commands: Sequence[str],
    pronunciations: Mapping[str, Sequence[str]],
    distances: PhoneDistances | None,
) -> list[list[float]]:
    pairs = find_similar(commands, pronunciations, at_least=0.0, distances=distances)
    alike = {frozenset((pair.first, pair.second)): pair.similarity for pair in pairs}
    return [[alike.get(frozenset((row, column)), 1.0) for column in commands] for row in commands]
