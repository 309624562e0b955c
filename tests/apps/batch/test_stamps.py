"""What changed is found by its bytes, and nothing is read whose size and time are the same."""

from __future__ import annotations

import os
import tempfile
from collections.abc import Callable
from pathlib import Path

import fsspec
import pytest
from hypothesis import given
from hypothesis import strategies as st

from voz.apps.batch.stamps import Stamp, check_stamps, stamp_of, with_checksum

CONTENTS = [None, b"", b"one", b"two", b"longer"]
"""Of a file; None if there is none."""

state = st.tuples(st.sampled_from(CONTENTS), st.sampled_from([1, 2]))


def put(path: Path, content: bytes | None, time: int) -> None:
    path.unlink(missing_ok=True)
    if content is not None:
        path.write_bytes(content)
        os.utime(path, (time, time))


def whole_stamp(path: Path) -> Stamp | None:
    stamp = stamp_of(str(path))
    return stamp and with_checksum(stamp, path)


@given(st.lists(st.tuples(state, state), max_size=5))
def test_what_changed_is_found_and_what_is_gone_has_not_changed(
    states: list[tuple[tuple[bytes | None, int], tuple[bytes | None, int]]],
) -> None:
    with tempfile.TemporaryDirectory() as folder:
        paths = [Path(folder, str(number)) for number in range(len(states))]
        for path, (before, _) in zip(paths, states, strict=True):
            put(path, *before)
        known = [(number, whole_stamp(path)) for number, path in enumerate(paths)]
        for path, (_, after) in zip(paths, states, strict=True):
            put(path, *after)
        found = {each.number: each for each in check_stamps([*map(str, paths)], known)}
        for number, ((content, time), (now, now_time)) in enumerate(states):
            same_look = content is not None and now is not None and len(content) == len(now)
            if now is None or (same_look and time == now_time):
                assert number not in found
            else:
                assert found[number].changed == (content != now)


def test_many_are_looked_at_and_each_is_named_by_its_number(tmp_path: Path) -> None:
    names = [str(tmp_path / str(number)) for number in range(3000)]
    for name in names:
        Path(name).touch()
    known = [(number, stamp_of(name)) for number, name in enumerate(names)]
    for number in (0, 1023, 1024, 2999):
        Path(names[number]).write_bytes(b"x")
    assert [each.number for each in check_stamps(names, known)] == [0, 1023, 1024, 2999]


def test_what_was_not_read_to_its_end_has_changed_as_soon_as_its_time_has(tmp_path: Path) -> None:
    path = tmp_path / "a.wav"
    put(path, b"one", 1)
    known = [(0, stamp_of(str(path)))]
    assert not list(check_stamps([str(path)], known))
    put(path, b"one", 2)
    (looked,) = check_stamps([str(path)], known)
    assert looked.changed


def test_a_pipe_has_no_stamp_as_reading_it_would_empty_it(tmp_path: Path) -> None:
    os.mkfifo(tmp_path / "pipe")
    assert stamp_of(str(tmp_path / "pipe")) is None
    assert stamp_of("/dev/zero") is None
    assert stamp_of("a\0b") is None


@pytest.fixture
def server(tmp_path: Path, serve: Callable[[Path], str]) -> str:
    """A web server that says when a file was changed, in seconds, as most do."""
    return serve(tmp_path)


def changed(name: str, known: Stamp) -> list[bool]:
    return [each.changed for each in check_stamps([name], [(0, known)])]


def test_what_changed_on_a_web_server_is_found(server: str, tmp_path: Path) -> None:
    path, address = tmp_path / "a.wav", f"{server}/a.wav"
    put(path, b"one", 1)
    seen = stamp_of(address)
    assert seen
    known = with_checksum(seen, path)
    assert changed(address, known) == []
    put(path, b"one", 5)
    assert changed(address, known) == [False]
    put(path, b"two", 5)
    assert changed(address, known) == [True]
    put(path, b"longer", 1)
    assert changed(address, known) == [True]
    path.unlink()
    assert changed(address, known) == []
    assert stamp_of(address) is None


def test_what_changed_in_a_store_of_objects_is_found(tmp_path: Path) -> None:
    address, path = "memory://stamps/a.wav", tmp_path / "a.wav"
    store = fsspec.filesystem("memory")
    path.write_bytes(b"one")
    store.pipe(address, b"one")
    seen = stamp_of(address)
    assert seen
    known = with_checksum(seen, path)
    assert changed(address, known) == []
    store.pipe(address, b"one")
    assert changed(address, known) == [False]
    store.pipe(address, b"two")
    assert changed(address, known) == [True]
