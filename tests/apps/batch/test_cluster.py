"""A real scheduler of dask's and real workers on loopback: one dies half-way, nothing is lost."""

from __future__ import annotations

import os
import re
import signal
import subprocess
import sys
from collections.abc import Iterator
from contextlib import ExitStack, contextmanager
from pathlib import Path

import pytest
from calls import in_process
from distributed import Client
from recordings import ROOT, Recording

from voz.apps.batch.executors import dask_executor
from voz.apps.batch.outcomes import ErrorRow, Outcome
from voz.apps.batch.scheduler import Scheduler
from voz.apps.batch.worker import WorkerSetup
from voz.errors import ConfigError
from voz.settings import Recognition

pytestmark = pytest.mark.slow

SETUP = WorkerSetup(str(ROOT / "lm"), Recognition(use_network=False))


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
    folder = tmp_path_factory.mktemp("cluster")
    with scheduling(folder) as address, workers(address, 2, folder):
        yield address


@pytest.fixture
def cluster(one_cluster: str) -> str:
    """A scheduler with two workers, both there again after the test before."""
    with Client(one_cluster, set_as_default=False) as client:
        client.wait_for_workers(2)
    return one_cluster


def decoded(address: str, names: list[str], limit: float | None = None) -> dict[str, Outcome]:
    with dask_executor(address, SETUP) as pool:
        known = list(Scheduler(pool, names, range(len(names)), limit).run())
    assert sorted(number for number, _ in known) == list(range(len(names)))
    return {names[number]: outcome for number, outcome in known}


def error(outcome: Outcome) -> str:
    (row,) = outcome.rows
    assert isinstance(row, ErrorRow)
    return row.error


@pytest.fixture
def names(recordings: list[Recording]) -> list[str]:
    return [str(r.path) for r in recordings if r.kind == "command"][:24]


def test_a_worker_that_is_killed_half_way_loses_nothing(
    scheduler: str, names: list[str], tmp_path: Path
) -> None:
    """Without a nanny: it does not come back."""
    with (
        workers(scheduler, 2, tmp_path, "--no-nanny") as processes,
        dask_executor(scheduler, SETUP) as pool,
    ):
        numbers = []
        for number, outcome in Scheduler(pool, names, range(len(names))).run():
            if len(numbers) == len(names) // 2:
                os.kill(processes[0], signal.SIGKILL)
            assert not outcome.failed
            numbers.append(number)
    assert sorted(numbers) == list(range(len(names)))


def test_what_workers_die_of_is_one_row(cluster: str, names: list[str]) -> None:
    outcomes = decoded(cluster, [*names[:8], "poison://x", *names[8:12]])
    assert error(outcomes["poison://x"]).startswith("poison://x: made its worker end twice")
    assert not any(outcomes[name].failed for name in names[:12])


def test_what_never_ends_is_one_row(cluster: str, names: list[str]) -> None:
    outcomes = decoded(cluster, [*names[:4], "endless://x"], limit=4.0)
    assert error(outcomes["endless://x"]).startswith("endless://x: takes too long")
    assert not any(outcomes[name].failed for name in names[:4])


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
        dask_executor(scheduler, SETUP),
    ):
        pass


def test_workers_with_other_models_refuse(cluster: str, names: list[str]) -> None:
    other = WorkerSetup(SETUP.folder, SETUP.settings, fingerprint="another")
    with (
        dask_executor(cluster, other) as pool,
        pytest.raises(ConfigError, match="other language files"),
    ):
        list(Scheduler(pool, names, range(len(names))).run())


def test_a_cluster_that_is_not_there_is_a_line(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("voz.apps.batch.executors.CONNECT_TIMEOUT", 1)
    with (
        pytest.raises(ConfigError, match="no answer"),
        dask_executor("tcp://[::1]:1", SETUP),
    ):
        pass
