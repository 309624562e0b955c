"""Runs the program of a node: an error is one line, and zero velocity comes last."""

from __future__ import annotations

import sys
from collections.abc import Callable
from typing import NoReturn

from voz.errors import VozError
from voz.printable import printable
from voz.process import signals
from voz.process.exit_codes import WRONG_CALL
from voz.process.setup import set_up
from voz.process.standard_streams import quiet_libraries, unblocked_output
from voz.ros1.node import Ros1Node


def run_node(name: str, work: Callable[[Ros1Node], None]) -> NoReturn:
    """Run `work` as a node until a signal or `rosnode kill` ends it: both are a good end."""
    signals.install(shell_exit_code=False)
    set_up()
    code = 1
    try:
        with quiet_libraries(), unblocked_output(), Ros1Node(name, sys.argv[1:]) as node:
            work(node)
        code = 0
    except VozError as error:
        print(printable(f"{name}: {error}"), file=sys.stderr)
        code = WRONG_CALL
    except BaseException:
        # A signal raises while the node starts; cut short by it, an import may raise anything.
        by_signal = signals.exit_code()
        if by_signal is None:
            raise
        code = by_signal
    finally:
        signals.restore_default_handlers()
        if signals.is_audio_thread_left():
            signals.force_exit(code)
    sys.exit(code)
