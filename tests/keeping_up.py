"""Tests that go by the clock are tried again where the machine was too busy for them."""

from __future__ import annotations

import threading
import time
from pathlib import Path

import pytest
from _pytest.runner import runtestprotocol

STALL = 0.04
"""A thread that only sleeps and wakes, and was late by so much, s: nothing here is in time."""

CROWDED = 0.2
"""Somebody waited for a processor for this part of the time: so may the test have."""

PRESSURE = Path("/proc/pressure/cpu")
"""Which tells that: https://docs.kernel.org/accounting/psi.html"""

BY_THE_CLOCK = {"pulse", "own_pulse"}
"""Fixtures of tests that hear or play: sound does not wait."""

TRIES = 3
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
def pytest_runtest_protocol(item: pytest.Item, nextitem: pytest.Item | None) -> bool | None:
    """Try a test that is slow or by sound again when it fails, if the machine had no time for it.

    Slow ones wait for other programs and clocks. The machine had no time if it did not let even a
    sleeping thread wake in time, or if somebody waited for a processor often. On one that has, the
    first failure counts, and on any the third; those that were tried again are told with the
    report.
    """
    fixtures = getattr(item, "fixturenames", ())  # those of the fixtures too
    if item.get_closest_marker("slow") is None and BY_THE_CLOCK.isdisjoint(fixtures):
        return None
    item.ihook.pytest_runtest_logstart(nodeid=item.nodeid, location=item.location)
    failures: list[str] = []
    for _ in range(TRIES):
        item._initrequest()  # type: ignore[attr-defined]  # fixtures of its own are made anew
        with Metronome() as metronome:
            reports = runtestprotocol(item, log=False, nextitem=nextitem)
        for report in reports:
            report.user_properties += [(AGAIN, failure) for failure in failures]
        failed = [report for report in reports if report.failed]
        if metronome.keeps_up or not failed:
            break
        failures += [_why(report) for report in failed]
    for report in reports:
        item.ihook.pytest_runtest_logreport(report=report)
    item.ihook.pytest_runtest_logfinish(nodeid=item.nodeid, location=item.location)
    return True


def _why(report: pytest.TestReport) -> str:
    """Where and by what a test failed, in a line."""
    crash = getattr(report.longrepr, "reprcrash", None)
    if crash is None:
        return report.longreprtext.strip().rpartition("\n")[2]
    return f"  {crash.path}:{crash.lineno}: {crash.message.partition(chr(10))[0]}"


def pytest_terminal_summary(terminalreporter: pytest.TerminalReporter) -> None:
    """Tell which tests were tried again, and why."""
    for category in ("passed", "failed"):
        for report in terminalreporter.getreports(category):
            why = [str(value) for name, value in report.user_properties if name == AGAIN]
            if why and report.when == "call":
                terminalreporter.write_line(f"{AGAIN}: {report.nodeid}")
                terminalreporter.write_line("\n".join(why))
