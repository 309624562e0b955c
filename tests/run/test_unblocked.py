"""Outputs that nobody reads hold up nobody, and nothing is lost of those that somebody does."""

from __future__ import annotations

import os
import subprocess
import sys

import pytest

from voz.run.unblocked import MOST_WAITING, Unblocked

PROGRAM = """
import sys
from voz.run.unblocked import unblocked_output
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
        out, err = program.communicate(timeout=30)
    assert out.splitlines() == [*(f"line {n} \N{SNOWMAN}" for n in range(200)), "after"]
    assert err.splitlines() == [f"error {n}" for n in range(200)]


@pytest.mark.parametrize(("then", "code"), [("", 0), ("raise RuntimeError", 1)])
def test_who_writes_to_what_nobody_reads_does_not_wait_and_ends(then: str, code: int) -> None:
    with started(
        MOST_WAITING * 2, then, stdout=subprocess.PIPE, stderr=subprocess.STDOUT
    ) as program:  # which fills the pipe
        assert program.wait(30) == code


def test_what_a_terminal_cannot_show_is_escaped() -> None:
    ours, theirs = os.pipe()
    stream = Unblocked(theirs, "ascii")
    stream.write("caf\xe9\udcff\n")
    assert stream.end()
    assert os.read(ours, 100) == b"caf\\xe9\\udcff\n"
    os.close(ours)
    os.close(theirs)


def test_who_writes_learns_that_nobody_reads_any_more() -> None:
    ours, theirs = os.pipe()
    stream = Unblocked(theirs, "utf-8")
    os.close(ours)
    stream.write("x")
    assert stream.end()
    with pytest.raises(BrokenPipeError):
        stream.write("x")
    os.close(theirs)
