"""Signals that end the program: by an exception while it starts, by a message while it drives."""

from __future__ import annotations

import _thread
import os
import signal
import sys
import time
from contextlib import contextmanager

TYPE_CHECKING = False  # `typing` takes its time, and until they are taken signals are tracebacks
if TYPE_CHECKING:
    from collections.abc import Callable, Iterator, Sequence
    from types import FrameType

BY_SIGNAL = 128
"""Exit code when a signal ended the program, to which the signal's number is added."""

AGAIN = 0.02
"""After an exception was swallowed, the next try, s: what swallowed it is over by then."""


ENDING = (signal.SIGINT, signal.SIGTERM, signal.SIGQUIT)


class _State:
    taken: Sequence[signal.Signals] = ()
    first: int | None = None
    as_in_shells = True
    wake: Callable[[], None] | None = None
    only_noted = False


def install(as_in_shells: bool = True) -> None:
    """Take the signals that end a program; the first thing it does, before it imports others.

    Until a run drives, each raises SystemExit, which ends the program by way of all `finally`
    blocks.

    Args:
        as_in_shells: whether the exit code is 128 and the number of the first; else it is 0.
    """
    _State.first, _State.wake, _State.only_noted = None, None, False
    _State.as_in_shells = as_in_shells
    # A shell starts what it puts in the background with Ctrl-C ignored, and a robot must stop all
    # the same; whoever says `nohup` means it.
    numbers = list(ENDING)
    if signal.getsignal(signal.SIGHUP) is not signal.SIG_IGN:
        numbers.append(signal.SIGHUP)
    _State.taken = numbers
    for number in numbers:
        signal.signal(number, _received)
    signal.pthread_sigmask(signal.SIG_UNBLOCK, numbers)  # who started it may have blocked them
    sys.unraisablehook = _swallowed


def let_go() -> None:
    """Let signals do what they do to any program: all is stopped, and only its end is left.

    An exception that they raise while Python ends would be printed, and caught by nobody.
    """
    for number in _State.taken:
        signal.signal(number, signal.SIG_DFL)


def ended_by() -> int | None:
    """The number of the first signal that came; None if none did."""
    return _State.first


def exit_code() -> int | None:
    """What the program is to end with, as a signal came; None if none did."""
    if _State.first is None:
        return None
    return BY_SIGNAL + _State.first if _State.as_in_shells else 0


@contextmanager
def let_signals_wake(wake: Callable[[], None]) -> Iterator[None]:
    """Let signals only be noted in a `with` block, as an exception could cut anything in two.

    After a signal has ended the block others are noted, and nothing more: a second Ctrl-C must
    not keep the robot from being stopped.

    Args:
        wake: is called at each, between any two lines of the main thread: it only puts a message
            into a queue.

    Raises:
        SystemExit: a signal came before, and something swallowed what it raised.
    """
    _State.wake = wake
    try:
        _end_if_asked()
        yield
    finally:
        _State.only_noted = _State.first is not None
        _State.wake = None


def _received(number: int, frame: FrameType | None) -> None:
    if _State.first is None:
        _State.first = number
    if frame is not None and frame.f_code is _swallowed.__code__:
        return  # what it raised there would be printed; the next try is on its way
    if _State.wake:
        _State.wake()
    elif not _State.only_noted:
        _end_if_asked()


def _end_if_asked() -> None:
    if _State.first is not None:
        raise SystemExit(exit_code())


def _swallowed(unraisable: sys.UnraisableHookArgs) -> None:
    """Take an exception that nobody can catch: ours, in a callback of an import, is tried again."""
    if not (isinstance(unraisable.exc_value, SystemExit) and _State.first is not None):
        sys.__unraisablehook__(unraisable)
    if _State.first is not None:
        # Raised here it would be swallowed again; such a thread keeps no program from its end.
        _thread.start_new_thread(_signal_again, (_State.first,))


def _signal_again(number: int) -> None:
    time.sleep(AGAIN)
    os.kill(os.getpid(), number)
