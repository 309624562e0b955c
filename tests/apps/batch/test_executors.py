"""Workers that die, hang or eat: nothing else is lost, and what did it is one row."""

from __future__ import annotations

import os
import resource
import signal
import subprocess
import sys
import time
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest
from programs import is_alive
from recordings import ROOT, Recording

from voz.apps.batch.executors import InlineExecutor, ProcessExecutor, process_executor
from voz.apps.batch.outcomes import ErrorRow, Outcome, UtteranceRow
from voz.apps.batch.scheduler import Scheduler
from voz.apps.batch.worker import WorkerSetup
from voz.errors import ConfigError
from voz.settings import Recognition

SETUP = WorkerSetup(str(ROOT / "lm"), Recognition(use_network=False), memory=500_000_000)

pytestmark = pytest.mark.slow


@pytest.fixture
def names(recordings: list[Recording]) -> list[str]:
    return [str(r.path) for r in recordings if r.kind == "command"][:10]


@pytest.fixture
def pool(monkeypatch: pytest.MonkeyPatch) -> Iterator[ProcessExecutor]:
    folder = str(Path(__file__).parent)
    monkeypatch.setenv("PYTHONPATH", os.pathsep.join([folder, os.environ.get("PYTHONPATH", "")]))
    with process_executor(SETUP, 2) as pool:
        yield pool


def decoded(
    pool: ProcessExecutor, names: list[str], limit: float | None = None
) -> dict[str, Outcome]:
    known = list(Scheduler(pool, names, range(len(names)), limit).run())
    assert sorted(number for number, _ in known) == list(range(len(names)))
    return {names[number]: outcome for number, outcome in known}


def is_heard(outcome: Outcome) -> bool:
    return all(isinstance(row, UtteranceRow) for row in outcome.rows)


def error(outcome: Outcome) -> str:
    (row,) = outcome.rows
    assert isinstance(row, ErrorRow)
    return row.error


@pytest.mark.parametrize(
    ("bad", "said"),
    [
        ("poison://x", "made its worker end twice (killed by signal 9)"),
        ("crash://x", "made its worker end twice (killed by signal 11)"),
        ("hungry://x", "needs more than 500 MB of memory"),
    ],
)
def test_what_its_worker_dies_of_is_one_row(
    pool: ProcessExecutor, names: list[str], bad: str, said: str
) -> None:
    outcomes = decoded(pool, [*names[:5], bad, *names[5:]])
    assert error(outcomes[bad]).startswith(f"{bad}: {said}")
    assert all(is_heard(outcomes[name]) for name in names)


def test_what_never_ends_is_one_row(pool: ProcessExecutor, names: list[str]) -> None:
    outcomes = decoded(pool, ["endless://x", *names], limit=5.0)
    assert error(outcomes["endless://x"]).startswith("endless://x: takes too long")
    assert all(is_heard(outcomes[name]) for name in names)


def test_what_a_worker_died_beside_is_done_in_the_end(
    pool: ProcessExecutor, names: list[str], tmp_path: Path
) -> None:
    once = f"once://{tmp_path / 'killed'}"
    outcomes = decoded(pool, [*names, once])
    assert "cannot be fetched" in error(outcomes[once])
    assert all(is_heard(outcomes[name]) for name in names)


def test_a_worker_that_is_killed_from_outside_loses_nothing(
    pool: ProcessExecutor, names: list[str]
) -> None:
    scheduler = Scheduler(pool, names, range(len(names)))
    known: list[Any] = []
    for each in scheduler.run():
        if not known:
            for worker in children_of(os.getpid()):
                os.kill(worker, signal.SIGKILL)
        known.append(each)
    assert sorted(number for number, _ in known) == list(range(len(names)))
    assert all(is_heard(outcome) for _, outcome in known)


def test_workers_with_other_models_refuse(names: list[str]) -> None:
    other = WorkerSetup(SETUP.folder, SETUP.settings, fingerprint="another")
    with (
        process_executor(other, 1) as pool,
        pytest.raises(ConfigError, match="other language files"),
    ):
        list(Scheduler(pool, names, range(len(names))).run())


def test_workers_end_with_the_process_that_began_them(tmp_path: Path) -> None:
    command = [sys.executable, "-c", PARENT, str(tmp_path), str(ROOT / "lm")]
    with subprocess.Popen(command) as parent:
        while not (tmp_path / "ready").exists():
            time.sleep(0.05)
        workers = children_of(parent.pid)
        parent.kill()
    assert workers
    while any(is_alive(worker) for worker in workers):
        time.sleep(0.05)


PARENT = """
import sys, time
from pathlib import Path
from voz.apps.batch.executors import process_executor
from voz.apps.batch.scheduler import Scheduler
from voz.apps.batch.worker import WorkerSetup
from voz.settings import Recognition

if __name__ == "__main__":
    with process_executor(WorkerSetup(sys.argv[2], Recognition()), 1) as pool:
        list(Scheduler(pool, ["none"] * 3, range(3)).run())
        Path(sys.argv[1], "ready").touch()
        time.sleep(600)
"""


def children_of(parent: int) -> list[int]:
    """The workers that a process began; multiprocessing has helpers besides."""
    found = []
    for status in Path("/proc").glob("[0-9]*/status"):
        try:
            is_child = f"PPid:\t{parent}\n" in status.read_text()
            command = (status.parent / "cmdline").read_bytes()
        except OSError:
            continue
        if is_child and b"spawn_main" in command:
            found.append(int(status.parent.name))
    return found


def test_decoding_here_leaves_this_process_its_memory(names: list[str]) -> None:
    before = resource.getrlimit(resource.RLIMIT_DATA)
    (known,) = Scheduler(InlineExecutor(SETUP), names[:1], range(1), None).run()
    assert is_heard(known[1])
    assert resource.getrlimit(resource.RLIMIT_DATA) == before
