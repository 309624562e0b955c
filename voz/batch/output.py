"""A run whose results go into a file: what is there already is kept, the rest is added."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from typing import TypeAlias

from voz.batch.fingerprint import Header
from voz.batch.formats import by_file, format_of, reading
from voz.batch.journal import check_same_run, journal_for
from voz.batch.places import Place, exists, journal_path, shown_place, state_of, written
from voz.batch.rows import Outcome, Row
from voz.batch.scheduler import Known
from voz.errors import ConfigError

Decode: TypeAlias = Callable[[Sequence[int]], Iterator[Known]]
"""Decodes recordings, given their numbers, in any order."""


@dataclass(frozen=True)
class Going:
    """How a run goes on from another one.

    Attributes:
        resume: whether what is there is kept.
        failed: whether recordings that failed are tried again.
        heard: is told of each outcome that is new.
        total: is told, before any, how many there will be.
    """

    resume: bool
    failed: bool
    heard: Callable[[Outcome], None]
    total: Callable[[int], None]


def decode_into(
    output: Place,
    header: Header,
    names: Sequence[str],
    decode: Decode,
    going: Going,
    whole: Callable[[Outcome], None],
) -> None:
    """Decode recordings into a file; until it is whole the old one stays.

    Args:
        output: a file or an object elsewhere; its ending says how it is written.
        header: what the results hang on.
        names: of the recordings, as results name them.
        decode: decodes some of them.
        going: how it goes on.
        whole: is told of all outcomes in order, as they are written.

    Raises:
        ConfigError: it cannot be written, or holds what cannot be gone on with.
    """
    write = format_of(output).write
    before = state_of(output)
    finished = _finished(output, header) if going.resume else iter(())
    with journal_for(output, header, names, going.resume, finished) as journal:
        left = journal.missing(going.failed)
        going.total(len(left))
        for number, outcome in decode(left) if left else ():
            journal.add(names[number], outcome)
            going.heard(outcome)

        def rows() -> Iterator[Row]:
            for outcome in journal.outcomes():
                whole(outcome)
                yield from outcome.rows

        with _telling_what_is_kept(), written(output) as path:
            if state_of(output) != before:
                raise ConfigError(f"{shown_place(output)}: was written by another run meanwhile")
            write(path, header, rows())
        journal_path(output).unlink()


@contextmanager
def _telling_what_is_kept() -> Iterator[None]:
    try:
        yield
    except ConfigError as error:
        raise ConfigError(f"{error}; what was decoded is kept, go on by --resume") from error


def _finished(output: Place, header: Header) -> Iterator[tuple[str, tuple[Row, ...]]]:
    """What an output holds that is whole; nothing if there is none."""
    if not exists(output):
        return
    with reading(output) as (there, rows):
        check_same_run(there, header, output)
        yield from by_file(rows)


def in_order(known: Iterator[Known]) -> Iterator[Outcome]:
    """Put outcomes into the order of the input; those that came too early are kept until then."""
    early: dict[int, Outcome] = {}
    following = 0
    for number, outcome in known:
        early[number] = outcome
        while following in early:
            yield early.pop(following)
            following += 1
