"""Merges the outputs of all shards into the one that a single run would have made."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from contextlib import ExitStack
from typing import TypeVar

from msgspec.structs import replace

from voz.apps.batch.fingerprint import Header, difference
from voz.apps.batch.formats import format_of, group_by_file, open_output, write_output
from voz.apps.batch.inputs import parse_shard
from voz.apps.batch.locations import journal_path, output_file
from voz.apps.batch.outcomes import Row
from voz.apps.batch.remote import shown_name
from voz.apps.batch.stamps import read_stamps, write_stamps
from voz.errors import ConfigError

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
        differing = difference(first, header)
        if not differing and header.inputs != first.inputs:
            differing = "another list of recordings"
        if not differing and header.columns != first.columns:
            differing = "another manifest"
        if differing:
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
    while True:
        for number, group in enumerate(groups):
            following = next(group, None)
            if following is None:
                ended = True
            elif ended:
                raise ConfigError(f"shard {number + 1}: has more recordings than the one before it")
            else:
                yield following[1]
        if ended:
            return
