"""Programs and functions that commands start: each on a thread of its own, and for a limited time.

The beat waits for none of them; the end of each is an event. No shell reads what was said.
"""

from __future__ import annotations

import os
import shutil
import signal
import subprocess
import threading
from collections.abc import Callable
from contextlib import suppress
from difflib import get_close_matches
from functools import partial
from pathlib import Path
from typing import Any

from voz.control.steps import SLOT
from voz.control.table import CommandTable
from voz.errors import ConfigError
from voz.events import CallFunction, Event, ProgramEnded, StartProgram
from voz.printable import printable_output
from voz.process.forks import ends_forks
from voz.robot.user_code import describe_error, import_target, is_by_signal
from voz.speech.builtin_sounds import BuiltinSound

MAX_PROGRAMS = 8
"""Programs and functions that run at once; more are not started."""

DEFAULT_TIME_LIMIT = 60.0
"""Of a program whose command gives none, s."""

MAX_PROGRAM_LINE = 1000
"""Characters of a line that a program prints; a longer one comes in pieces."""

LAST_OUTPUT_TIMEOUT = 0.5
"""To show what a program printed before its end is reported, s; its own children may print on."""


class Programs:
    """Starts programs and functions; the end of the `with` block ends all programs."""

    def __init__(
        self,
        table: CommandTable,
        report: Callable[[ProgramEnded], None],
        show: Callable[[str], None],
        wait: bool = False,
    ) -> None:
        """Load the functions, before anything moves.

        `report` takes the end of each, `show` each line that a program prints, both on any thread.
        `wait` is whether to wait for the end of each, as in a run without a clock.

        Raises:
            ConfigError: there is no such function, program or sound.
        """
        self._report = report
        self._show = show
        self._wait = wait
        self._functions: dict[str, Callable[..., Any]] = {}
        self.add(table)
        self._running: set[subprocess.Popen[str]] = set()
        self._places = threading.Semaphore(MAX_PROGRAMS)
        self._closed = False

    def add(self, table: CommandTable) -> None:
        """Load the functions of another table too, on any thread; raises ConfigError."""
        functions: dict[str, Callable[..., Any]] = {}
        for state, name, step in table.all_steps():
            error_at = partial(table.error_at, state, name)
            if step.call:
                target = str(step.call[0])
                functions[target] = _imported(target, error_at)
            if step.run:
                _check_program(step.run[0], error_at)
            if step.play:
                _check_sound(step.play, error_at)
        self._functions = {**self._functions, **functions}

    def receive(self, event: Event) -> None:
        """Start what an event asks for."""
        if not isinstance(event, StartProgram | CallFunction):
            return
        name = event.program[0] if isinstance(event, StartProgram) else event.function
        if not self._places.acquire(blocking=False):
            self._report(
                ProgramEnded(event.t, name, f"not started: {MAX_PROGRAMS} others have not ended")
            )
            return
        thread = threading.Thread(
            target=self._do, args=(event, name), name="voz-program", daemon=True
        )
        thread.start()
        if self._wait:
            thread.join()

    def __enter__(self) -> Programs:
        return self

    def __exit__(self, *_: object) -> None:
        self._closed = True
        for program in list(self._running):
            _kill(program)

    def _do(self, event: StartProgram | CallFunction, name: str) -> None:
        try:
            problem = self._run(event) if isinstance(event, StartProgram) else self._call(event)
        finally:
            self._places.release()
        if not self._closed:
            self._report(ProgramEnded(event.t, name, problem))

    def _run(self, event: StartProgram) -> str:
        """Run a program to its end; return what went wrong."""
        limit = event.seconds or DEFAULT_TIME_LIMIT
        # ALSA's plugin for PulseAudio blocks it; then `yes | head` complains of a broken pipe.
        signal.pthread_sigmask(signal.SIG_UNBLOCK, [signal.SIGPIPE])
        try:
            program = subprocess.Popen(
                event.program,
                stdin=subprocess.DEVNULL,
                stdout=subprocess.PIPE,
                stderr=subprocess.STDOUT,
                text=True,
                errors="backslashreplace",
                start_new_session=True,
            )
        except (OSError, ValueError) as error:
            return f"cannot be started ({error})"
        self._running.add(program)
        if self._closed:  # meanwhile; `__exit__` has not seen this one
            _kill(program)
        output = threading.Thread(
            target=self._show_output, args=(program,), name="voz-program-output", daemon=True
        )
        output.start()
        try:
            code = program.wait(limit)
        except subprocess.TimeoutExpired:
            _kill(program)
            return f"was ended after {limit:g} s"
        finally:
            self._running.discard(program)
            output.join(LAST_OUTPUT_TIMEOUT)
        return f"exit code {code}" if code else ""

    def _show_output(self, program: subprocess.Popen[str]) -> None:
        assert program.stdout
        name = Path(program.args[0]).name  # type: ignore[index,arg-type]
        with program.stdout as lines:
            while line := lines.readline(MAX_PROGRAM_LINE):
                self._show(printable_output(f"{name}: {line}"))

    def _call(self, event: CallFunction) -> str:
        """Call a function; return what it raised. One that hangs cannot be ended."""
        limit = event.seconds or DEFAULT_TIME_LIMIT
        hangs = ProgramEnded(event.t, event.function, f"has not ended after {limit:g} s")
        late = threading.Timer(limit, self._report, [hangs])
        late.daemon = True
        late.start()
        try:
            with ends_forks():
                self._functions[event.function](*event.arguments)
        except BaseException as error:  # `sys.exit` too
            return describe_error(error)
        finally:
            late.cancel()
        return ""


def _kill(program: subprocess.Popen[str]) -> None:
    with suppress(ProcessLookupError, PermissionError):
        os.killpg(program.pid, signal.SIGKILL)
    program.wait()


def _imported(target: str, error_at: Callable[[str], ConfigError]) -> Callable[..., Any]:
    try:
        found = import_target(target)
    except (Exception, SystemExit) as error:
        if is_by_signal(error):
            raise
        raise error_at(
            f"calls {target}, which cannot be imported ({describe_error(error)})"
        ) from error
    if not callable(found):
        raise error_at(f"calls {target}, which is no function")
    return found  # type: ignore[no-any-return]


def _check_program(program: str, error_at: Callable[[str], ConfigError]) -> None:
    if program and not SLOT.search(program) and not shutil.which(program):
        raise error_at(
            f"runs {program}, and there is no such program; give its path, or install it"
        )


def _check_sound(sound: str, error_at: Callable[[str], ConfigError]) -> None:
    builtin = [each.title for each in BuiltinSound]
    if not SLOT.search(sound) and sound not in builtin and not Path(sound).is_file():
        near = get_close_matches(sound, builtin, 1)
        meant = f"did you mean {near[0]}?" if near else "`voz sound --list` shows the others"
        raise error_at(f"plays {sound}, and there is no such file; {meant}")
