"""How far a long run is, how fast it goes and how long it will take."""

from __future__ import annotations

import sys
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from voz.apps.batch.outcomes import Outcome


class Progress:
    """A bar on standard error, for a `with` block; nothing where nobody can see it."""

    def __init__(self, begin: Callable[[int], None], heard: Callable[[Outcome], None]) -> None:
        self.begin = begin
        self.heard = heard


@contextmanager
def progress(shown: bool = True) -> Iterator[Progress]:
    """Show a bar, unless `shown` is False; give what takes the total, and each outcome."""
    if not (shown and sys.stderr.isatty()):
        yield Progress(lambda _: None, lambda _: None)
        return
    from rich.console import Console
    from rich.progress import BarColumn, MofNCompleteColumn, TextColumn, TimeRemainingColumn
    from rich.progress import Progress as Bar

    columns = (
        TextColumn("Decoding"),
        BarColumn(),
        MofNCompleteColumn(),
        TextColumn("{task.fields[rate]}"),
        TimeRemainingColumn(),
    )
    with Bar(*columns, console=Console(stderr=True), transient=True) as bar:
        task = bar.add_task("", total=None, rate="")
        hours = 0.0

        def heard(outcome: Outcome) -> None:
            nonlocal hours
            hours += outcome.seconds / 3600
            took = bar.tasks[0].elapsed or 1.0
            done = bar.tasks[0].completed + 1
            bar.update(task, advance=1, rate=f"{done / took:.1f}/s, {hours / took * 3600:.0f}x")

        yield Progress(lambda total: bar.update(task, total=total), heard)
