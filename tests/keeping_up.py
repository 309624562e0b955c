"""A test that fails is tried again where the machine was too busy for it."""

from __future__ import annotations

import faulthandler
import fcntl
import os
import tempfile
import threading
import time
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

import pytest
from _pytest.faulthandler import fault_handler_stderr_fd_key
from _pytest.runner import runtestprotocol

STALL = 0.04
"""A thread that only sleeps and wakes, and was late by so much, s: nothing here is in time."""

CROWDED = 0.2
"""Somebody waited for a processor for this part of the time: so may the test have."""

PRESSURE = Path("/proc/pressure/cpu")
"""Which tells that: https://docs.kernel.org/accounting/psi.html"""

TRIES = 8
AMONG_OTHERS = 2
"""So many of them while other tests run, and then alone, once the machine has time again."""

CALM = 3.0
"""It has when it had for so long, s."""

PATIENCE, IN_ALL = 60.0, 600.0
"""For so long a try waits for that, and all of a process, s: a host may hold it up for minutes."""

ROOM = Path(tempfile.gettempdir()) / f"voz-tests-{os.getuid()}.lock"
"""Whose bytes the tests of all processes lock: the first while they enter, the second inside."""

WAITED = pytest.StashKey[float]()

AGAIN = "tried again on a busy machine"


def waited_for_processors() -> float:
    """How long somebody waited for a processor since the computer started, s; 0 if untold."""
    if not PRESSURE.exists():
        return 0.0
    return int(PRESSURE.read_text().split("total=")[1].split()[0]) / 1e6


class Metronome:
    """Notices whether the machine lets threads wait."""

    def __init__(self) -> None:
        self.late = 0.0  # at most, s
        self._begun, self._waited = time.monotonic(), waited_for_processors()
        self._over = threading.Event()
        self._thread = threading.Thread(target=self._work, daemon=True)

    def __enter__(self) -> Metronome:
        self._thread.start()
        return self

    def __exit__(self, *_: object) -> None:
        self._over.set()
        self._thread.join()

    @property
    def keeps_up(self) -> bool:
        """Whether it did not."""
        crowded = waited_for_processors() - self._waited
        return self.late < STALL and crowded < CROWDED * (time.monotonic() - self._begun)

    def _work(self) -> None:
        before = time.monotonic()
        while not self._over.wait(0.01):
            now = time.monotonic()
            self.late = max(self.late, now - before - 0.01)
            before = now


@pytest.hookimpl(tryfirst=True)
def pytest_runtest_protocol(item: pytest.Item, nextitem: pytest.Item | None) -> bool:
    """Try a test again when it fails, if the machine had no time for it.

    It had none if it did not let even a sleeping thread wake in time, or if somebody waited for a
    processor often: what goes by a clock or by sound, or waits for another program, may fail then.
    On a machine that has time the first failure counts, and on any the eighth; each begins with
    fixtures of its own, those of a module or a session too, and with as much time as the first.
    Those that were tried again are told with the report.
    """
    item.ihook.pytest_runtest_logstart(nodeid=item.nodeid, location=item.location)
    failures: list[str] = []
    for number in range(TRIES):
        alone = number >= AMONG_OTHERS
        with _room(alone):
            if alone:
                _wait_for_calm(item.session.stash)
            _begin_timeout(item.config)
            item._initrequest()  # type: ignore[attr-defined]  # fixtures of its own are made anew
            with Metronome() as metronome:
                reports = runtestprotocol(item, log=False, nextitem=nextitem)
        for report in reports:
            report.user_properties += [(AGAIN, failure) for failure in failures]
        failed = [report for report in reports if report.failed]
        if metronome.keeps_up or not failed:
            break
        failures += [_why(report) for report in failed]
        if number < TRIES - 1:
            failures += _begin_anew(item.session)
    for report in reports:
        item.ihook.pytest_runtest_logreport(report=report)
    item.ihook.pytest_runtest_logfinish(nodeid=item.nodeid, location=item.location)
    return True


@contextmanager
def _room(alone: bool) -> Iterator[None]:
    """Run among the tests of other processes, or wait until they are over and run alone."""
    with ROOM.open("a+") as file:  # who closes it, or is killed, lets go of it
        fcntl.lockf(file, fcntl.LOCK_EX, 1, 0)  # before those that come later
        fcntl.lockf(file, fcntl.LOCK_EX if alone else fcntl.LOCK_SH, 1, 1)
        if not alone:
            fcntl.lockf(file, fcntl.LOCK_UN, 1, 0)
        yield


def _begin_timeout(config: pytest.Config) -> None:
    """Let pytest's own end of a test that hangs count from now on."""
    timeout = float(config.getini("faulthandler_timeout"))
    if timeout:
        file = config.stash[fault_handler_stderr_fd_key]
        hangs = config.getini("faulthandler_exit_on_timeout")
        faulthandler.dump_traceback_later(timeout, file=file, exit=hangs)


def _begin_anew(session: pytest.Session) -> list[str]:
    """Take down what tests share: a try left it in the midst of something; gives what failed."""
    try:
        session._setupstate.teardown_exact(None)
    except Exception as error:
        return [f"  taking it down: {error!r}"]
    return []


def _wait_for_calm(stash: pytest.Stash) -> None:
    begun = time.monotonic()
    waited = stash.get(WAITED, 0.0)
    until = begun + min(PATIENCE, IN_ALL - waited)
    calm = False
    while not calm and time.monotonic() < until:
        with Metronome() as metronome:
            time.sleep(CALM)
        calm = metronome.keeps_up
    stash[WAITED] = waited + time.monotonic() - begun


def _why(report: pytest.TestReport) -> str:
    """Where and by what a test failed, in a line."""
    crash = getattr(report.longrepr, "reprcrash", None)
    if crash is None:
        return report.longreprtext.strip().rpartition("\n")[2]
    # An assertion with a message of its own has what differed in the second line.
    return f"  {crash.path}:{crash.lineno}: {' '.join(crash.message.splitlines()[:2])}"


def pytest_terminal_summary(terminalreporter: pytest.TerminalReporter) -> None:
    """Tell which tests were tried again, and why."""
    again: dict[str, list[str]] = {}
    for category in ("passed", "failed", "error"):
        for report in terminalreporter.getreports(category):
            told = getattr(report, "user_properties", ())  # a file that cannot be read has none
            if why := [str(value) for name, value in told if name == AGAIN]:
                again[report.nodeid] = why
    for test, why in again.items():
        terminalreporter.write_line(f"{AGAIN}: {test}")
        terminalreporter.write_line("\n".join(why))
