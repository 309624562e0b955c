"""Chooses who decodes: this process, workers on this machine, or a cluster."""

from __future__ import annotations

from collections.abc import Generator, Sequence
from contextlib import AbstractContextManager, nullcontext
from dataclasses import dataclass
from pathlib import Path

from msgspec.structs import replace

from voz.apps.batch.executors import Executor, InlineExecutor, process_executor
from voz.apps.batch.long_recordings import is_long
from voz.apps.batch.remote import is_remote
from voz.apps.batch.scheduler import Finished, Scheduler
from voz.apps.batch.tasks import WorkerSetup
from voz.process.worker_pool import cores

MOST_INLINE_RECORDINGS = 2
"""So few are decoded before another process has started."""


@dataclass(frozen=True)
class BatchDecoder:
    """How recordings are decoded."""

    setup: WorkerSetup
    jobs: int | None = None  # processes; None for one on each core
    limit: float | None = None  # for a recording, s; None for its length and a minute
    careful: bool = False  # whether a recording must not end this process, however few there are
    cluster: str | None = None  # address of a dask scheduler; None for this machine

    def decode(
        self, names: Sequence[str], numbers: Sequence[int]
    ) -> Generator[Finished, None, None]:
        """Decode the recordings with these indexes; yields the outcomes as they come.

        Raises:
            VozError: the models cannot be loaded, or the cluster cannot be reached.
        """
        with self._executor([names[number] for number in numbers]) as executor:
            yield from Scheduler(executor, names, numbers, self.limit).run()

    def _executor(self, names: Sequence[str]) -> AbstractContextManager[Executor]:
        if self.cluster:
            from voz.apps.batch.cluster import dask_executor

            # dask limits the memory of its workers itself.
            setup = replace(self.setup, memory=None, base=str(Path.cwd()))
            return dask_executor(self.cluster, setup)
        jobs = self.jobs or cores()
        if not self.careful and self.limit is None and (jobs == 1 or _is_little(names)):
            return nullcontext(InlineExecutor(self.setup))
        return process_executor(self.setup, jobs)


def _is_little(names: Sequence[str]) -> bool:
    here = [name for name in names[: MOST_INLINE_RECORDINGS + 1] if not is_remote(name)]
    return len(names) <= MOST_INLINE_RECORDINGS and not any(is_long(Path(name)) for name in here)
