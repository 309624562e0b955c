"""What `voz decode` shows: a table or lines of JSON, and how far it is."""

from __future__ import annotations

import sys
from collections.abc import Callable, Iterator
from functools import partial
from typing import TYPE_CHECKING

import msgspec

from voz.cli.text_io import show, show_raw

if TYPE_CHECKING:
    from voz.apps.batch.outcomes import Row, UtteranceRow
    from voz.apps.batch.scheduler import Finished
    from voz.cli.decode_options import DecodeOptions


def writer(options: DecodeOptions) -> Callable[[Row], None]:
    """Return what shows each row, after the head of a table."""
    if options.as_json:
        return _show_json
    show(f"   start      end  sure  accepted  {'text':32}  file")
    return partial(_show_row, detailed=options.verbose)


def _show_json(row: Row) -> None:
    from voz.apps.batch.outcomes import row_fields

    show_raw(msgspec.json.encode(row_fields(row)).decode())


def _show_row(row: Row, detailed: bool) -> None:
    from voz.apps.batch.outcomes import ErrorRow, SilentRow

    if isinstance(row, ErrorRow):
        show(f"{'':>26} error {row.error}")
    elif isinstance(row, SilentRow):
        show(f"{'':8} {row.seconds:8.2f}  {'':4}  {'':8}  {'(nothing is said)':32}  {row.file}")
    else:
        _show_heard(row, detailed)


def _show_heard(row: UtteranceRow, detailed: bool) -> None:
    from voz.events import evidence_in_words, explain

    accepted = "yes" if row.accepted else "no"
    explained = row.reason and explain(row.reason, row.between)
    why = f"({explained})" if explained else ""
    text = " ".join(part for part in (row.text, why) if part)
    show(
        f"{row.start:8.2f} {row.end:8.2f}  {row.confidence:.2f}  {accepted:8}  "
        f"{text:32}  {row.file}"
    )
    for alternative in row.best:
        show(f"{'':19}{alternative.confidence:.2f}  {'':8}  {alternative.text}")
    if row.words:
        words = ", ".join(f"{each.word} {each.start:.2f}-{each.end:.2f}" for each in row.words)
        show(f"{'':35}{words}")
    if detailed and (detail := evidence_in_words(row.score, row.next_best)):
        show(f"{'':35}{detail}")


def with_progress(finished: Iterator[Finished], total: int) -> Iterator[Finished]:
    """Show how far, how fast and how long a run goes on, where somebody sees standard error."""
    if not sys.stderr.isatty():
        yield from finished
        return
    from rich.console import Console
    from rich.progress import (
        BarColumn,
        MofNCompleteColumn,
        Progress,
        TextColumn,
        TimeRemainingColumn,
    )

    columns = (
        TextColumn("Decoding"),
        BarColumn(),
        MofNCompleteColumn(),
        TextColumn("{task.fields[rate]}"),
        TimeRemainingColumn(),
    )
    with Progress(*columns, console=Console(stderr=True), transient=True) as bar:
        task = bar.add_task("", total=total, rate="")
        seconds = 0.0
        for done, one in enumerate(finished, start=1):
            seconds += one.outcome.seconds
            took = bar.tasks[0].elapsed or 1.0
            bar.update(task, advance=1, rate=f"{done / took:.1f}/s, {seconds / took:.0f}x")
            yield one
