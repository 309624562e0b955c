"""What `voz decode` shows and keeps: a table, lines of JSON, files, and how far it is."""

from __future__ import annotations

import sys
import time
from collections.abc import Callable, Generator, Iterable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, field
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING

import msgspec

from voz.apps.batch.outcomes import Totals
from voz.cli.text_io import info, show, show_raw, warn
from voz.errors import ConfigError
from voz.files import shown_path

if TYPE_CHECKING:
    from voz.apps.batch.batch_decoder import BatchDecoder, Finished
    from voz.apps.batch.fingerprint import Header
    from voz.apps.batch.inputs import Inputs
    from voz.apps.batch.outcomes import Outcome, Row, UtteranceRow
    from voz.apps.evaluation.results import Result
    from voz.apps.recordings.manifest import Clip
    from voz.cli.decode_command import DecodeOptions
    from voz.config import Config


MOST_WARNINGS = 10
"""Warnings about recordings that are shown; the others are counted."""


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
        TimeElapsedColumn,
        TimeRemainingColumn,
    )

    columns = (
        TextColumn("Decoding"),
        BarColumn(),
        MofNCompleteColumn(),
        TextColumn("{task.fields[rate]}"),
        TimeRemainingColumn(),
        TimeElapsedColumn(),  # moves while one long recording is decoded
    )
    with Progress(*columns, console=Console(stderr=True), transient=True) as bar:
        task = bar.add_task("", total=total, rate="")
        seconds = 0.0
        for done, one in enumerate(finished, start=1):
            seconds += one.outcome.seconds
            took = bar.tasks[0].elapsed or 1.0
            bar.update(task, advance=1, rate=f"{done / took:.1f}/s, {seconds / took:.0f}x")
            yield one


def with_warnings(finished: Iterator[Finished]) -> Iterator[Finished]:
    """Show what of recordings was read otherwise than it stands there; many are counted."""
    warned = 0
    for one in finished:
        for warning in one.outcome.warnings:
            warned += 1
            if warned <= MOST_WARNINGS:
                warn(warning)
        yield one
    if warned > MOST_WARNINGS:
        warn(f"{warned - MOST_WARNINGS:,} more recordings of these kinds")


@dataclass
class OutputSummary:
    """The counts of a run."""

    said: set[str]  # recordings whose text is known, as results name them
    new: Totals = field(default_factory=Totals)  # what this run decoded
    whole: Totals = field(default_factory=Totals)  # what is in the output
    heard: dict[str, Outcome] = field(default_factory=dict)  # the results of those in `said`
    begun: float = field(default_factory=time.monotonic)  # when, s

    def add(self, outcome: Outcome) -> None:
        """Count what goes into the output."""
        self.whole.add(outcome)
        if (file := outcome.rows[0].file) in self.said:
            self.heard[file] = outcome

    def report(self, output: str, inputs: Inputs) -> None:
        """Show the counts to the user."""
        known = self.whole.files - self.new.files
        kept = f" ({known:,} were known)" if known else ""
        info(f"written: {output}, {self.whole.files:,} recordings{kept}")
        for line in self.new.lines(time.monotonic() - self.begun):
            info(line)
        _report_scores(inputs, self.heard)


def decode_to_file(
    options: DecodeOptions, settings: Config, header: Header, inputs: Inputs, decoder: BatchDecoder
) -> bool:
    """Decode recordings into `--out`, and report; return whether some could not be read."""
    from msgspec.structs import replace

    from voz.apps.batch.alignments import with_text_grids
    from voz.apps.batch.fingerprint import digest_of
    from voz.apps.batch.inputs import shard_of
    from voz.apps.batch.locations import check_output, shown_name
    from voz.apps.batch.output import ResumeOptions, decode_to_output

    assert options.out
    output, names = options.out, inputs.names
    header = replace(header, columns=inputs.columns)
    if options.shard:
        header = replace(header, shard=options.shard, inputs=digest_of(names))
        names = shard_of(names, options.shard)
    options.check_written(
        settings, [output], [name for name in names if Path(name) == Path(output)]
    )
    check_output(output, options.resumes or options.overwrite, "continue it with --resume, ")
    summary = OutputSummary({shown_name(str(clip.path)) for clip in inputs.clips})

    def decode(numbers: Sequence[int]) -> Generator[Finished, None, None]:
        decoded = with_warnings(decoder.decode(names, numbers))
        if options.textgrids:
            decoded = with_text_grids(decoded, options.textgrids)
        for finished in with_progress(decoded, len(numbers)):
            summary.new.add(finished.outcome)
            yield finished

    resume = ResumeOptions(options.resumes, options.retry_failed, options.overwrite, info)
    with _explaining_resume(output):
        decode_to_output(
            output, header, names, decode, resume, manifest=inputs.manifest, on_outcome=summary.add
        )
    summary.report(output, inputs)
    return summary.whole.failed > 0


@contextmanager
def _explaining_resume(output: str) -> Iterator[None]:
    """If a signal ends the `with` block, say that the results so far are kept."""
    from voz.apps.batch.locations import journal_path

    try:
        yield
    except (SystemExit, KeyboardInterrupt):
        if journal_path(output).exists():
            info(f"the results so far are kept in {journal_path(output)}: continue with --resume")
        raise


def _report_scores(inputs: Inputs, heard: dict[str, Outcome]) -> None:
    """Report how well the recordings of manifests were understood."""
    results = list(_results(inputs.clips, heard))
    if not results:
        return
    from voz.extras import require

    try:
        require("report", "jiwer")
    except ConfigError as error:
        info(f"no scores: {error}")
        return
    from voz.apps.evaluation.scores import score
    from voz.apps.evaluation.tables import main_tables, table_text

    for table in main_tables(score(results), []):
        for line in ("", *table_text(table).split("\n")):
            info(line)


def _results(clips: Iterable[Clip], outcomes: Mapping[str, Outcome]) -> Iterator[Result]:
    """Combine manifests with outcomes; stretches of streams are left to `voz eval`."""
    from msgspec.structs import replace

    from voz.apps.batch.outcomes import UtteranceRow
    from voz.apps.evaluation.results import Understood, empty_result

    for clip in clips:
        outcome = outcomes.get(shown_path(clip.path))
        if clip.start is None and outcome is not None and not outcome.failed:
            heard = [row for row in outcome.rows if isinstance(row, UtteranceRow)]
            yield replace(
                empty_result(clip),
                heard=tuple(
                    Understood(h.text, h.confidence, h.accepted, h.start, h.end) for h in heard
                ),
                seconds=outcome.seconds,
                cpu=outcome.cpu,
            )
