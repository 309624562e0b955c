"""Writes an output: results that are there are kept, the others added; and merges shards."""

from __future__ import annotations

from collections.abc import Callable, Generator, Iterator, Mapping, Sequence
from contextlib import ExitStack, closing, contextmanager
from dataclasses import dataclass
from itertools import chain, zip_longest
from typing import TypeAlias, TypeVar

from msgspec.structs import replace

from voz.apps.batch.batch_decoder import Finished
from voz.apps.batch.fingerprint import Header, difference
from voz.apps.batch.formats import format_of, group_by_file, open_output, write_output
from voz.apps.batch.inputs import parse_shard
from voz.apps.batch.journal import Journal, NamedOutcomes, check_same_run, open_journal
from voz.apps.batch.locations import exists, journal_path, object_state, output_file, shown_name
from voz.apps.batch.outcomes import ManifestFields, Outcome, Row, with_manifest
from voz.apps.batch.stamps import RecordingStamp, check_stamps, read_stamps, stamp_of, write_stamps
from voz.errors import ConfigError

DecodeFunction: TypeAlias = Callable[[Sequence[int]], Generator[Finished, None, None]]
"""Decodes the recordings with these indexes, in any order."""

MOST_NAMED = 10
"""Changed recordings that are named to the user; there may be a million."""


@dataclass(frozen=True)
class ResumeOptions:
    """How a run goes on from another one."""

    resume: bool  # whether what is there is kept
    failed: bool  # whether recordings that failed are tried again
    overwrite: bool  # whether what is there is replaced
    notice: Callable[[str], None]  # shows the user a message


def decode_to_output(
    output: str,
    header: Header,
    names: Sequence[str],
    decode: DecodeFunction,
    options: ResumeOptions,
    *,
    manifest: Mapping[str, ManifestFields],
    on_outcome: Callable[[Outcome], None],
) -> None:
    """Decode recordings into an output; until it is whole the old one stays.

    Args:
        output: a file or an address; its ending gives the format.
        header: what the results depend on.
        names: paths and addresses of the recordings.
        decode: decodes some of them.
        options: how to go on from an earlier run.
        manifest: what manifests say of recordings, by their names in results.
        on_outcome: called with all outcomes in order, as they are written.

    Raises:
        ConfigError: it cannot be written, or is of another run.
    """
    format_of(output)  # before the work: raises if there is none
    before = object_state(output)
    shown = [shown_name(name) for name in names]
    finished = _finished(output, header, options) if options.resume else iter(())
    with open_journal(
        output,
        header,
        shown,
        resume=options.resume,
        finished=finished,
        overwrite=options.overwrite,
    ) as journal:
        changed = _changed(journal, names, options) if options.resume else []
        left = sorted({*journal.missing(options.failed), *changed})
        if left:
            with closing(decode(left)) as outcomes:
                for number, outcome in outcomes:
                    journal.add(shown[number], outcome)

        def rows() -> Iterator[Row]:
            for outcome in journal.outcomes():
                on_outcome(outcome)
                yield from with_manifest(outcome.rows, manifest.get(outcome.rows[0].file, {}))

        with _say_that_results_are_kept(), output_file(output) as path:
            if object_state(output) != before:
                raise ConfigError(f"{shown_name(output)}: was written by another run meanwhile")
            write_output(path, header, rows())
        write_stamps(output, (stamped for _, stamped in journal.stamps()))
        journal.remove()


@contextmanager
def _say_that_results_are_kept() -> Iterator[None]:
    try:
        yield
    except ConfigError as error:
        raise ConfigError(
            f"{error}; the results so far are kept, continue with --resume"
        ) from error


def _changed(journal: Journal, names: Sequence[str], options: ResumeOptions) -> list[int]:
    """Find, and name to the user, the recordings that changed since they were decoded."""
    known = ((number, stamped.stamp) for number, stamped in journal.stamps())
    looked = list(check_stamps(names, known))
    journal.set_stamps((each.number, each.now) for each in looked if not each.changed)
    changed = [each.number for each in looked if each.changed]
    if changed:
        some = ", ".join(shown_name(names[number]) for number in changed[:MOST_NAMED])
        more = f" and {len(changed) - MOST_NAMED:,} more" if len(changed) > MOST_NAMED else ""
        options.notice(f"changed since, decoded again: {some}{more}")
    return changed


def _finished(output: str, header: Header, options: ResumeOptions) -> NamedOutcomes:
    """The outcomes in a finished output; none if there is no output."""
    if not exists(output):
        return
    with open_output(output) as (there, rows), read_stamps(output) as stamps:
        check_same_run(there, header, output)
        if stamps is None:
            options.notice(
                f"{shown_name(output)}: has no .recordings file of its own, so its recordings "
                "count as unchanged; --overwrite decodes them again"
            )
        for file, together in group_by_file(rows):
            stamp = next(stamps, RecordingStamp(file)).stamp if stamps else stamp_of(file)
            plain = with_manifest(together, {})  # which may say something else now
            yield file, Outcome(tuple(plain), stamp=stamp)


Of = TypeVar("Of")
"""What is known of a recording."""


def merge(shards: Sequence[str], output: str) -> int:
    """Merge the outputs of shards, in the order of the input; returns the number of recordings.

    Raises:
        ConfigError: one is missing, there twice, unfinished, or made by other models.
    """
    format_of(output)  # before the work: raises if there is none
    with ExitStack() as files:
        opened = [(path, *files.enter_context(open_output(_ended(path)))) for path in shards]
        _check_headers([(path, header) for path, header, _ in opened])
        opened.sort(key=lambda one: parse_shard(one[1].shard)[0])
        count = 0

        def rows() -> Iterator[Row]:
            nonlocal count
            groups = [group_by_file(read) for _, _, read in opened]
            for of_file in _in_turn(groups):
                count += 1
                yield from of_file

        whole = replace(opened[0][1], shard="", inputs="")
        with output_file(output) as path:
            write_output(path, whole, rows())
        known = [files.enter_context(read_stamps(path)) for path, _, _ in opened]
        stamps = [((each.file, each) for each in of_shard) for of_shard in known if of_shard]
        if len(stamps) == len(opened):
            write_stamps(output, _in_turn(stamps))
    return count


def _ended(path: str) -> str:
    if journal_path(path).exists():
        raise ConfigError(
            f"{shown_name(path)}: its run is unfinished; continue it with --resume first"
        )
    return path


def _check_headers(headers: Sequence[tuple[str, Header]]) -> None:
    """Refuse shards that do not make a whole."""
    first_path, first = headers[0]
    there = set()
    for path, header in headers:
        if not header.shard:
            raise ConfigError(f"{shown_name(path)}: is not a shard: it was made without --shard")
        if differing := difference(first, header, "inputs", "columns"):
            raise ConfigError(
                f"{shown_name(path)}: was made with {differing} than {shown_name(first_path)}"
            )
        there.add(header.shard)
    count = parse_shard(first.shard)[1]
    missing = [f"{n}/{count}" for n in range(1, count + 1) if f"{n}/{count}" not in there]
    if missing:
        raise ConfigError(f"shard {', '.join(missing[:5])}: is missing; name the outputs of all")
    if len(there) < len(headers):
        raise ConfigError("a shard is named twice; name each once")


def _in_turn(groups: Sequence[Iterator[tuple[str, Of]]]) -> Iterator[Of]:
    """Interleave the recordings of the shards, as they were dealt out."""
    ended = False
    for number, dealt in enumerate(chain.from_iterable(zip_longest(*groups))):
        if dealt and ended:
            shard = number % len(groups) + 1
            raise ConfigError(f"shard {shard}: has more recordings than another, which was cut")
        if dealt:
            yield dealt[1]
        ended = not dealt
