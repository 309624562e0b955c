"""A run whose results go into a file: what is there already is kept, the rest is added."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from typing import TypeAlias

import msgspec

from voz.apps.batch.fingerprint import Header
from voz.apps.batch.formats import format_of, group_by_file, open_output
from voz.apps.batch.journal import Journal, JournalEntry, check_same_run, open_journal
from voz.apps.batch.locations import (
    Location,
    exists,
    journal_path,
    object_state,
    output_file,
    shown_location,
)
from voz.apps.batch.outcomes import Outcome, Row
from voz.apps.batch.remote import shown_name
from voz.apps.batch.scheduler import Finished
from voz.apps.batch.stamp_file import RecordingStamp, read_stamps, write_stamps
from voz.apps.batch.stamps import check_stamps, stamp_of
from voz.errors import ConfigError

DecodeFunction: TypeAlias = Callable[[Sequence[int]], Iterator[Finished]]
"""Decodes recordings, given their numbers, in any order."""

MOST_NAMED = 10
"""Recordings that are named to the user at most; there may be a million."""


@dataclass(frozen=True)
class ResumeOptions:
    """How a run goes on from another one.

    Attributes:
        resume: whether what is there is kept.
        failed: whether recordings that failed are tried again.
        overwrite: whether what is there is replaced.
        heard: is told of each outcome that is new.
        total: is told, before any, how many there will be.
        notice: is told what the user should know of what was there.
    """

    resume: bool
    failed: bool
    overwrite: bool
    heard: Callable[[Outcome], None]
    total: Callable[[int], None]
    notice: Callable[[str], None]


def decode_to_output(
    output: Location,
    header: Header,
    names: Sequence[str],
    decode: DecodeFunction,
    going: ResumeOptions,
    whole: Callable[[Outcome], None],
) -> None:
    """Decode recordings into a file; until it is whole the old one stays.

    Args:
        output: a file or an object elsewhere; its ending says how it is written.
        header: what the results hang on.
        names: paths and addresses of the recordings.
        decode: decodes some of them.
        going: how it goes on.
        whole: is told of all outcomes in order, as they are written.

    Raises:
        ConfigError: it cannot be written, or holds what cannot be gone on with.
    """
    write = format_of(output).write
    before = object_state(output)
    shown = [shown_name(name) for name in names]
    finished = _finished(output, header, going) if going.resume else iter(())
    with open_journal(output, header, shown, going.resume, finished, going.overwrite) as journal:
        changed = _changed(journal, names, going) if going.resume else []
        left = sorted({*journal.missing(going.failed), *changed})
        going.total(len(left))
        for number, outcome in decode(left) if left else ():
            journal.add(shown[number], outcome)
            going.heard(outcome)

        def rows() -> Iterator[Row]:
            for outcome in journal.outcomes():
                whole(outcome)
                yield from outcome.rows

        with _telling_what_is_kept(), output_file(output) as path:
            if object_state(output) != before:
                raise ConfigError(f"{shown_location(output)}: was written by another run meanwhile")
            write(path, header, rows())
        write_stamps(output, (stamped for _, stamped in journal.stamps()))
        journal_path(output).unlink()


@contextmanager
def _telling_what_is_kept() -> Iterator[None]:
    try:
        yield
    except ConfigError as error:
        raise ConfigError(f"{error}; what was decoded is kept, go on by --resume") from error


def _changed(journal: Journal, names: Sequence[str], going: ResumeOptions) -> list[int]:
    """Find and name the recordings that are not as they were when they were decoded."""
    known = ((number, stamped.stamp) for number, stamped in journal.stamps())
    looked = list(check_stamps(names, known))
    for each in looked:
        if not each.changed:
            journal.set_stamp(each.number, each.now)
    changed = [each.number for each in looked if each.changed]
    if changed:
        some = ", ".join(shown_name(names[number]) for number in changed[:MOST_NAMED])
        more = f" and {len(changed) - MOST_NAMED:,} more" if len(changed) > MOST_NAMED else ""
        going.notice(f"changed since, decoded again: {some}{more}")
    return changed


def _finished(output: Location, header: Header, going: ResumeOptions) -> Iterator[JournalEntry]:
    """What an output holds that is whole; nothing if there is none."""
    if not exists(output):
        return
    with open_output(output) as (there, rows), read_stamps(output) as stamps:
        check_same_run(there, header, output)
        if stamps is None:
            going.notice(
                f"{shown_location(output)}: has no .recordings file of its own, so its recordings "
                "count as unchanged; --overwrite decodes them again"
            )
        for file, together in group_by_file(rows):
            stamp = next(stamps, RecordingStamp(file)).stamp if stamps else stamp_of(file)
            yield JournalEntry(file, tuple(map(msgspec.to_builtins, together)), stamp=stamp)


def in_input_order(known: Iterator[Finished]) -> Iterator[Outcome]:
    """Put outcomes into the order of the input; those that came too early are kept until then."""
    early: dict[int, Outcome] = {}
    following = 0
    for number, outcome in known:
        early[number] = outcome
        while following in early:
            yield early.pop(following)
            following += 1
