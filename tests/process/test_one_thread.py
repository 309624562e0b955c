"""Matrices are computed on one thread, also where numpy was loaded with more."""

from __future__ import annotations

import subprocess
import sys

import pytest
from threadpoolctl import threadpool_info

from voz.process.one_thread import on_one_thread

PROGRAM = """
import numpy
from threadpoolctl import threadpool_info, threadpool_limits
from voz.process.one_thread import on_one_thread

threads = lambda: [x["num_threads"] for x in threadpool_info() if x["user_api"] == "blas"]
threadpool_limits(2)
print(threads(), on_one_thread(threads)(), threads())
"""


def test_it_is_so_while_a_function_runs_and_no_longer() -> None:
    done = subprocess.run([sys.executable, "-c", PROGRAM], capture_output=True, text=True)
    assert done.stdout == "[2] [1] [2]\n", done.stderr


def test_what_the_function_gives_and_raises_is_passed_on() -> None:
    @on_one_thread
    def divided(number: int, by: int) -> float:
        """Docstring."""
        assert all(x["num_threads"] == 1 for x in threadpool_info() if x["user_api"] == "blas")
        return number / by

    assert divided(6, by=3) == 2
    assert divided.__doc__ == "Docstring."
    with pytest.raises(ZeroDivisionError):
        divided(1, 0)
