"""The level of a microphone as a bar."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from contextlib import contextmanager

from rich.console import Console
from rich.progress import BarColumn, Progress, TextColumn

from voz.audio import Samples
from voz.audio.recording_level import dbfs

LEVEL_BAR_START = -60.0
"""The left end, dBFS; the right end is 0."""

LEVEL_BAR_WIDTH = 30


@contextmanager
def level_bar(console: Console, indent: str = "") -> Iterator[Callable[[Samples], None]]:
    """Show a level bar in a `with` block, below what is printed, if the console is a terminal.

    Yields a function that takes a block of the microphone.
    """
    columns = TextColumn(indent + "{task.description}"), BarColumn(LEVEL_BAR_WIDTH)
    with Progress(*columns, console=console, transient=True, disable=not console.is_terminal) as p:
        bar = p.add_task("level", total=-LEVEL_BAR_START)
        yield lambda block: p.update(bar, completed=max(0.0, dbfs(block) - LEVEL_BAR_START))


def level_line(samples: Samples) -> str:
    """A level as a bar of text, for a console that is no terminal."""
    level = dbfs(samples)
    length = round(LEVEL_BAR_WIDTH * max(0.0, level - LEVEL_BAR_START) / -LEVEL_BAR_START)
    return f"level {level:5.0f} dBFS  {'#' * length}".rstrip()
