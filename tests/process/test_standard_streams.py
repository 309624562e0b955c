"""Libraries are kept quiet, and writes to a stream that nobody reads do not block."""

from __future__ import annotations

import os
import subprocess
import sys

import pytest
from programs import PATIENCE

from voz.process.standard_streams import MAX_QUEUED_TEXTS, UnblockedStream

PROGRAM = """
import sys
from voz.process.standard_streams import unblocked_output
with unblocked_output():
    for number in range({lines}):
        print("line", number, "\\N{{SNOWMAN}}")
        print("error", number, file=sys.stderr)
    assert not sys.stdout.isatty() and sys.stdout.fileno() == 1
print("after", flush=True)
{then}
"""


def started(lines: int, then: str = "", **outputs: int) -> subprocess.Popen[str]:
    program = PROGRAM.format(lines=lines, then=then)
    return subprocess.Popen([sys.executable, "-c", program], text=True, **outputs)


def test_all_is_written_in_order_before_the_block_is_left() -> None:
    with started(200, stdout=subprocess.PIPE, stderr=subprocess.PIPE) as program:
        out, err = program.communicate(timeout=PATIENCE)
    assert out.splitlines() == [*(f"line {n} \N{SNOWMAN}" for n in range(200)), "after"]
    assert err.splitlines() == [f"error {n}" for n in range(200)]


@pytest.mark.parametrize(("then", "code"), [("", 0), ("raise RuntimeError", 1)])
def test_who_writes_to_what_nobody_reads_does_not_wait_and_ends(then: str, code: int) -> None:
    with started(
        MAX_QUEUED_TEXTS * 2, then, stdout=subprocess.PIPE, stderr=subprocess.STDOUT
    ) as program:  # which fills the pipe
        assert program.wait(PATIENCE) == code


def test_what_a_terminal_cannot_show_is_escaped() -> None:
    ours, theirs = os.pipe()
    stream = UnblockedStream(theirs, "ascii")
    stream.write("caf\xe9\udcff\n")
    assert stream.end()
    assert os.read(ours, 100) == b"caf\\xe9\\udcff\n"
    os.close(ours)
    os.close(theirs)


def test_who_writes_learns_that_nobody_reads_any_more() -> None:
    ours, theirs = os.pipe()
    stream = UnblockedStream(theirs, "utf-8")
    os.close(ours)
    stream.write("x")
    assert stream.end()
    with pytest.raises(BrokenPipeError):
        stream.write("x")
    os.close(theirs)


WRITES = """
import os, sys
from voz.process.standard_streams import quiet_libraries
{before}
try:
    with quiet_libraries():
        os.write(2, b"a library, ")
        print("voz é", file=sys.stderr)
        raise SystemExit(3)
finally:
    os.write(2, b"afterwards\\n")
"""


def standard_error(before: str = "") -> tuple[str, int]:
    command = [sys.executable, "-c", WRITES.format(before=before)]
    done = subprocess.run(command, capture_output=True, text=True, encoding="utf-8")
    return done.stderr, done.returncode


def test_libraries_are_not_seen_until_it_is_over() -> None:
    assert standard_error() == ("voz é\nafterwards\n", 3)


def test_what_was_under_way_comes_first() -> None:
    assert standard_error("print('before', file=sys.stderr)") == (
        "before\nvoz é\nafterwards\n",
        3,
    )


def test_a_program_without_standard_error_runs_all_the_same() -> None:
    assert standard_error("sys.stderr = None")[1] == 3
