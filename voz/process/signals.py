"""How the program ends: its exit codes; by a signal, or although an audio library hangs.

A signal raises an exception while the program starts, and sends a message while it drives.
"""

from __future__ import annotations

import _thread
import os
import signal
import sys
import time
from contextlib import contextmanager

STALE = 1
"""Exit code of `build-lm --check` when files are not up to date."""

NOT_WELL = 1
"""Exit code of `doctor` when something that is needed is not well."""

WRONG_CALL = 2
"""Exit code when an option, a file or a text cannot be used."""

SOME_UNREADABLE = 3
"""Exit code when some recordings could not be read; the others are done."""


TYPE_CHECKING = False  # `typing` is slow, and until `install` a signal is a traceback
if TYPE_CHECKING:
    from collections.abc import Callable, Iterator, Sequence
    from types import FrameType

SIGNAL_EXIT_CODE = 128
"""Exit code of a program that a signal ended, plus the signal's number."""

RESEND_DELAY = 0.02
"""Delay before a signal whose exception was swallowed is sent again, s."""

AUDIO_THREADS = ("voz-hearing", "voz-loudspeaker", "voz-renderer", "voz-speaker")
"""The threads that may be in PortAudio or a sound server's library."""

TERMINATING_SIGNALS = (signal.SIGINT, signal.SIGTERM, signal.SIGQUIT)


class _State:
    handled: Sequence[signal.Signals] = ()
    first: int | None = None
    shell_exit_code = True
    wake: Callable[[], None] | None = None
    ignore_more = False


def install(shell_exit_code: bool = True) -> None:
    """Handle the signals that end a program; to be called first, before other imports.

    Outside `defer_signals` each raises SystemExit, so that all `finally` blocks are run.

    Args:
        shell_exit_code: whether the exit code is 128 and the signal's number; else it is 0.
    """
    _State.first, _State.wake, _State.ignore_more = None, None, False
    _State.shell_exit_code = shell_exit_code
    # Also SIGINT, which a shell ignores for background jobs: a robot must stop.
    numbers = list(TERMINATING_SIGNALS)
    if signal.getsignal(signal.SIGHUP) is not signal.SIG_IGN:  # `nohup` ignores it
        numbers.append(signal.SIGHUP)
    _State.handled = numbers
    for number in numbers:
        signal.signal(number, _received)
    signal.pthread_sigmask(signal.SIG_UNBLOCK, numbers)  # the parent process may have blocked them
    sys.unraisablehook = _swallowed


def restore_default_handlers() -> None:
    """Restore Python's handlers: an exception at its end would be printed, not caught."""
    for number in _State.handled:
        signal.signal(number, signal.SIG_DFL)


def first_signal() -> int | None:
    """The number of the first signal that was received, if any."""
    return _State.first


def exit_code() -> int | None:
    """The exit code if a signal was received, else None."""
    if _State.first is None:
        return None
    return SIGNAL_EXIT_CODE + _State.first if _State.shell_exit_code else 0


@contextmanager
def defer_signals(wake: Callable[[], None]) -> Iterator[None]:
    """Let signals call `wake` instead of raising in a `with` block.

    It is called between any two lines of the main thread: it may only put a message into a queue.
    More signals after the first do nothing: a second Ctrl-C must not keep the robot from being
    stopped. Raises SystemExit for a signal whose exception was swallowed before.
    """
    _State.wake = wake
    try:
        _end_if_asked()
        yield
    finally:
        _State.ignore_more = _State.first is not None
        _State.wake = None


def _received(number: int, frame: FrameType | None) -> None:
    if _State.first is None:
        _State.first = number
    if frame is not None and frame.f_code is _swallowed.__code__:
        return  # an exception there would be printed; `_signal_again` is on its way
    if _State.wake:
        _State.wake()
    elif not _State.ignore_more:
        _end_if_asked()


def _end_if_asked() -> None:
    if _State.first is not None:
        raise SystemExit(exit_code())


def _swallowed(unraisable: sys.UnraisableHookArgs) -> None:
    """Handle an exception that nobody can catch, as in a callback of an import."""
    if not (isinstance(unraisable.exc_value, SystemExit) and _State.first is not None):
        sys.__unraisablehook__(unraisable)
    if _State.first is not None:
        # Raised here it would be swallowed again; a `_thread` does not delay the program's end.
        _thread.start_new_thread(_signal_again, (_State.first,))


def _signal_again(number: int) -> None:
    time.sleep(RESEND_DELAY)
    os.kill(os.getpid(), number)


def is_audio_thread_left() -> bool:
    """Whether a thread that may hang in an audio library is still running."""
    import threading

    return any(thread.name in AUDIO_THREADS for thread in threading.enumerate())


def force_exit(code: int) -> None:
    """Let the program end with an exit code after all is saved, without waiting for its threads.

    PortAudio's own exit handler would wait for a hanging sound server forever, or crash.
    """
    import atexit

    atexit.register(os._exit, code)
