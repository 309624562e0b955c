"""The `voz` command: a module for each group of subcommands, which read options and call voz.

What takes its time to import is imported inside the subcommand that needs it, so that
`voz --help` is there at once.
"""

from __future__ import annotations

import sys

if sys.platform == "win32":  # before the imports of what Windows does not have
    print("voz: needs Linux; on Windows use WSL 2, as docs/start.md says", file=sys.stderr)
    sys.exit(2)

from voz.process import setup, signals

TYPE_CHECKING = False
if TYPE_CHECKING:
    from collections.abc import Sequence

__all__ = ["main"]


def main(arguments: Sequence[str] | None = None) -> int:
    """Run the command line; a signal at any moment is a good end.

    Args:
        arguments: without the program's name; None takes those of the process.

    Returns:
        The exit code: 0, one of those in `process/signals.py`, or of a signal.
    """
    signals.install()
    setup.set_up()
    from voz.process.standard_streams import discard_unwritable_output, open_streams

    open_streams()
    code = 0
    try:
        from voz.cli.subcommands import call

        code = call(arguments)
    except BaseException as error:
        # Cut short by a signal, an import may raise anything.
        if signals.exit_code() is None:
            code = _without_memory(error)
    finally:
        signals.restore_default_handlers()
    discard_unwritable_output()
    by_signal = signals.exit_code()
    code = code if by_signal is None else by_signal
    if arguments is None and signals.is_audio_thread_left():
        signals.force_exit(code)
    return code


def _without_memory(error: BaseException) -> int:
    """Say in one line that there was not enough memory; raises any other error again."""
    from voz.process.setup import is_out_of_memory
    from voz.process.signals import WRONG_CALL

    if not is_out_of_memory(error):
        raise error
    print("voz: there is not enough memory; end other programs, or allow more", file=sys.stderr)
    return WRONG_CALL
