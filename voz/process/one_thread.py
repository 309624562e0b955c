"""Small matrices on one thread: several of numpy's wait for each other, worst on a busy machine."""

from __future__ import annotations

from collections.abc import Callable
from functools import cache, wraps
from typing import ParamSpec, TypeVar

from threadpoolctl import ThreadpoolController

P = ParamSpec("P")
R = TypeVar("R")


def on_one_thread(function: Callable[P, R]) -> Callable[P, R]:
    """Let a function compute its matrices on one thread, whatever is set for the process.

    With two, beside other programs on two cores, the second ear takes 130 ms for a word and not 6;
    to say so costs 10 microseconds.
    """

    @wraps(function)
    def alone(*args: P.args, **kwargs: P.kwargs) -> R:
        with _libraries().limit(limits=1):
            return function(*args, **kwargs)

    return alone


@cache
def _libraries() -> ThreadpoolController:
    return ThreadpoolController().select(user_api="blas")
