"""What C libraries write to standard error is kept away, what Python writes is not."""

from __future__ import annotations

import subprocess
import sys

WRITES = """
import os, sys
from voz.process.quiet_libraries import quiet_libraries
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
