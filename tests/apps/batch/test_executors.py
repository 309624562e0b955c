"""Workers that die, hang or eat, here and on a real cluster of dask: nothing else is lost."""

from __future__ import annotations

import os
import re
import resource
import signal
import subprocess
import sys
import time
from collections.abc import Iterator
from contextlib import ExitStack, contextmanager
from pathlib import Path
from typing import Any

import pytest
from calls import in_process
from distributed import Client
from programs import is_alive
from recordings import ROOT, Recording

from voz.apps.batch.batch_decoder import Scheduler
from voz.apps.batch.executors import (
    InlineExecutor,
    ProcessExecutor,
    dask_executor,
    process_executor,
)
from voz.apps.batch.outcomes import ErrorRow, Outcome, UtteranceRow
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


def test_what_its_worker_dies_of_is_one_row(pool: ProcessExecutor, names: list[str]) -> None:
    bad = {
        "poison://x": "made its worker end twice (killed by signal 9)",
        "crash://x": "made its worker end twice (killed by signal 11)",
        "hungry://x": "needs more than 500 MB of memory",
    }
    outcomes = decoded(pool, [*names[:5], *bad, *names[5:]])
    for name, said in bad.items():
        assert error(outcomes[name]).startswith(f"{name}: {said}")
    assert all(is_heard(outcomes[name]) for name in names)


def test_what_never_ends_is_one_row_and_the_next_is_done(
    pool: ProcessExecutor, names: list[str]
) -> None:
    (row,) = decoded(pool, ["endless://x"], limit=1.0).values()
    assert error(row).startswith("endless://x: takes too long")
    assert is_heard(decoded(pool, names[:1])[names[0]])


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
from voz.apps.batch.batch_decoder import Scheduler
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


UNLIMITED = WorkerSetup(str(ROOT / "lm"), Recognition(use_network=False))


@contextmanager
def dask(*arguments: str, until: str, cwd: Path) -> Iterator[tuple[subprocess.Popen[str], str]]:
    """A program of dask's, once it has said something; the folder of harm is in its path."""
    path = os.pathsep.join([str(Path(__file__).parent), os.environ.get("PYTHONPATH", "")])
    command = [sys.executable, "-m", "distributed.cli." + arguments[0], *arguments[1:]]
    with subprocess.Popen(
        command, stderr=subprocess.PIPE, text=True, env=os.environ | {"PYTHONPATH": path}, cwd=cwd
    ) as program:
        try:
            assert program.stderr is not None
            for line in program.stderr:
                if found := re.search(until, line):
                    yield program, found[1]
                    break
        finally:
            program.terminate()
            program.communicate()


@contextmanager
def scheduling(folder: Path) -> Iterator[str]:
    given = ("dask_scheduler", "--host", "127.0.0.1", "--port", "0", "--no-dashboard")
    until = r"Scheduler at:\s*(tcp://\S+)"
    with dask(*given, until=until, cwd=folder) as (_, address):
        yield address


@pytest.fixture
def scheduler(tmp_path: Path) -> Iterator[str]:
    with scheduling(tmp_path) as address:
        yield address


@contextmanager
def workers(address: str, count: int, cwd: Path, *more: str) -> Iterator[list[int]]:
    """Start workers, each with a nanny that starts it anew; gives the nannies' processes."""
    with ExitStack() as stack:
        given = ("dask_worker", address, "--nthreads", "1", "--no-dashboard", *more)
        registered = r"Registered to:\s*(tcp://\S+)"
        started = [
            stack.enter_context(dask(*given, until=registered, cwd=cwd)) for _ in range(count)
        ]
        yield [program.pid for program, _ in started]


@pytest.fixture(scope="module")
def one_cluster(tmp_path_factory: pytest.TempPathFactory) -> Iterator[str]:
    """Who kills a worker is given up sooner than usual: each of them takes seconds to come back."""
    folder = tmp_path_factory.mktemp("cluster")
    with pytest.MonkeyPatch.context() as patched:
        patched.setenv("DASK_DISTRIBUTED__SCHEDULER__ALLOWED_FAILURES", "1")
        with scheduling(folder) as address, workers(address, 2, folder):
            yield address


@pytest.fixture
def cluster(one_cluster: str) -> str:
    """A scheduler with two workers, both there again after the test before."""
    with Client(one_cluster, set_as_default=False) as client:
        client.wait_for_workers(2)
    return one_cluster


def decoded_by(
    address: str, many_names: list[str], limit: float | None = None
) -> dict[str, Outcome]:
    with dask_executor(address, UNLIMITED) as pool:
        known = list(Scheduler(pool, many_names, range(len(many_names)), limit).run())
    assert sorted(number for number, _ in known) == list(range(len(many_names)))
    return {many_names[number]: outcome for number, outcome in known}


@pytest.fixture
def many_names(recordings: list[Recording]) -> list[str]:
    return [str(r.path) for r in recordings if r.kind == "command"][:24]


def test_a_worker_that_is_killed_half_way_loses_nothing(
    scheduler: str, many_names: list[str], tmp_path: Path
) -> None:
    """Without a nanny: it does not come back."""
    with (
        workers(scheduler, 2, tmp_path, "--no-nanny") as processes,
        dask_executor(scheduler, UNLIMITED) as pool,
    ):
        numbers = []
        for number, outcome in Scheduler(pool, many_names, range(len(many_names))).run():
            if len(numbers) == len(many_names) // 2:
                os.kill(processes[0], signal.SIGKILL)
            assert not outcome.failed
            numbers.append(number)
    assert sorted(numbers) == list(range(len(many_names)))


def test_what_workers_die_of_is_one_row(cluster: str, many_names: list[str]) -> None:
    outcomes = decoded_by(cluster, [*many_names[:8], "poison://x", *many_names[8:12]])
    assert error(outcomes["poison://x"]).startswith("poison://x: made its worker end twice")
    assert not any(outcomes[name].failed for name in many_names[:12])


def test_what_never_ends_on_a_cluster_is_one_row(cluster: str, many_names: list[str]) -> None:
    (row,) = decoded_by(cluster, ["endless://x"], limit=0.5).values()
    assert error(row).startswith("endless://x: takes too long")
    assert not any(outcome.failed for outcome in decoded_by(cluster, many_names[:2]).values())


def test_the_output_is_that_of_one_machine(cluster: str, tmp_path: Path) -> None:
    """Workers are in another folder than the user."""
    given = ["decode", "audio_fixtures/commands", "none.wav", "--glob", "festival_slt__*.flac"]
    given += ["--no-network"]
    here, there = tmp_path / "here.jsonl", tmp_path / "there.jsonl"
    result = in_process(*given, "--out", there, "--dask", cluster, cwd=ROOT)
    assert (result.code, in_process(*given, "--out", here, cwd=ROOT).code) == (3, 3)
    assert there.read_bytes() == here.read_bytes()


def test_what_cannot_be_used_is_a_line(scheduler: str, tmp_path: Path) -> None:
    with (
        workers(scheduler, 1, tmp_path, "--nthreads", "2"),
        pytest.raises(ConfigError, match="has 2 threads; start workers with --nthreads 1"),
        dask_executor(scheduler, UNLIMITED),
    ):
        pass


def test_workers_of_a_cluster_with_other_models_refuse(cluster: str, many_names: list[str]) -> None:
    other = WorkerSetup(UNLIMITED.folder, UNLIMITED.settings, fingerprint="another")
    with (
        dask_executor(cluster, other) as pool,
        pytest.raises(ConfigError, match="other language files"),
    ):
        list(Scheduler(pool, many_names, range(len(many_names))).run())


def test_a_cluster_that_is_not_there_is_a_line(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("voz.apps.batch.executors.CONNECT_TIMEOUT", 1)
    with (
        pytest.raises(ConfigError, match="no answer"),
        dask_executor("tcp://[::1]:1", UNLIMITED),
    ):
        pass
