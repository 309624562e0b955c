"""Lines above what is drawn, as they stand on a terminal."""

from __future__ import annotations

import io

import pytest
from live_terminal import rows
from rich.console import Console
from rich.panel import Panel

from voz.terminal.live_terminal import MAX_WAITING_TEXTS, LiveTerminal


def printed(*texts: str) -> list[str]:
    """What stands above a panel in the end."""
    file = io.StringIO()
    terminal = Console(file=file, width=60, force_terminal=True, color_system="standard")
    drawn = LiveTerminal(terminal)
    with drawn.live(lambda: Panel("the panel")):
        for text in texts:
            drawn.write(text)
    seen = rows(file.getvalue())
    assert sum(row.startswith("╭") for row in seen) == 1
    return [row for row in seen if row and row[0] not in "╭│╰"]


def test_lines_stand_above_the_panel_in_their_order() -> None:
    texts = [f"line {number}\n" for number in range(30)]
    assert printed(*texts) == [text.rstrip() for text in texts]
    assert printed() == []


@pytest.mark.parametrize(
    "text", ["\x1b[2Jgone", "\x1b[5Agone", "10 %\rgone", "\x1b[31mgone\x1b[0m"]
)
def test_what_would_move_the_panel_is_left_out(text: str) -> None:
    assert printed(f"{text}\n") == ["gone"]


def test_of_too_many_the_last_are_printed_and_the_others_counted() -> None:
    lines = printed(*[f"line {number}\n" for number in range(50 * MAX_WAITING_TEXTS)])
    shown = [line for line in lines if line.startswith("line")]
    counted = [int(line.split()[1]) for line in lines if line.startswith("... ")]
    assert len(shown) + sum(counted) == 50 * MAX_WAITING_TEXTS
    assert len(shown) < len(counted) * MAX_WAITING_TEXTS + 1
    assert shown[-1] == f"line {50 * MAX_WAITING_TEXTS - 1}"
