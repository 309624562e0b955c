"""Little memory is one line, whatever needs it."""

from __future__ import annotations

import shlex
import subprocess

import pytest
from calls import VOZ
from recordings import GO_BACK, ROOT

from voz.process.memory import is_out_of_memory


@pytest.mark.parametrize(
    ("arguments", "kilobytes"),
    [
        (["decode", GO_BACK], 100_000),
        (["run", "--listening"], 250_000),
        (["serve"], 250_000),
        (["devices"], 60_000),
    ],
)
def test_where_little_memory_is_allowed_one_line_says_so(
    arguments: list[object], kilobytes: int
) -> None:
    call = f"ulimit -v {kilobytes}; {shlex.join([*VOZ, *map(str, arguments)])}"
    done = subprocess.run(["sh", "-c", call], cwd=ROOT, capture_output=True, text=True)
    assert (done.returncode, done.stdout) == (2, "")
    (line,) = done.stderr.splitlines()
    assert "memory" in line


def test_what_libraries_and_threads_say_of_it_is_known() -> None:
    assert is_out_of_memory(MemoryError())
    assert is_out_of_memory(ImportError("x.so: failed to map segment from shared object"))
    assert is_out_of_memory(RuntimeError("can't start new thread"))
    assert not is_out_of_memory(RuntimeError("a mistake"))
    assert not is_out_of_memory(ValueError("failed to map segment"))
