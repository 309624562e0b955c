"""The level as a bar."""

from __future__ import annotations

import io

import numpy as np
import pytest
from rich.console import Console

from voz.terminal.level_bar import LEVEL_BAR_WIDTH, level_bar, level_line


def tone(peak: float) -> np.ndarray:
    return (peak * np.sin(np.arange(1600) * 0.3)).astype(np.int16)


@pytest.mark.parametrize(
    ("peak", "length"),
    [(0, 0), (20, 0), (32767, LEVEL_BAR_WIDTH - 1), (32767 / 10 ** (27 / 20), 15)],
)
def test_a_line_is_as_long_as_it_is_loud(peak: float, length: int) -> None:
    assert level_line(tone(peak)).count("#") == pytest.approx(length, abs=1)


def test_silence_has_no_bar_and_no_space_behind_it() -> None:
    assert level_line(np.zeros(100, np.int16)) == "level   -90 dBFS"


@pytest.mark.parametrize("terminal", [True, False])
def test_a_bar_is_shown_where_it_can_move(terminal: bool, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("TERM", "xterm")  # in a dumb one nothing moves
    stream = io.StringIO()
    console = Console(file=stream, force_terminal=terminal, width=80)
    with level_bar(console, "   ") as show:
        for peak in (0, 100, 30_000):
            show(tone(peak))
    assert ("   level" in stream.getvalue()) == terminal
