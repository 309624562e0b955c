"""Hands recordings out to workers, and isolates those that workers die of."""

from __future__ import annotations

from collections import deque
from collections.abc import Iterator, Sequence
from concurrent.futures import Future, TimeoutError
from dataclasses import dataclass
from pathlib import Path
from queue import SimpleQueue
from typing import NamedTuple

from voz.apps.batch.executors import Executor
from voz.apps.batch.locations import is_remote, shown_name
from voz.apps.batch.outcomes import Outcome, failed_outcome
from voz.apps.batch.stamps import stamp_of
from voz.process.worker_pool import WorkerDied

MOST_FILES_PER_TASK = 1000
"""Most recordings in a task, however small they are."""

REMOTE_SIZE_BYTES = 500_000
"""Assumed size of a recording at an address, bytes."""

TASKS_PER_WORKER = 4
"""The recordings left are split into so many tasks a worker, so that the last ones are small."""

QUEUED_PER_WORKER = 2
"""Tasks that each worker has at a time, so that it never waits for the next one."""

LEAST_BYTES_PER_SECOND = 4000
"""Lowest rate of a compressed recording, from which the longest length of a file follows."""


class Finished(NamedTuple):
    """A recording that is decoded: its index in the input, and the outcome."""

    number: int
    outcome: Outcome


@dataclass(frozen=True)
class ScheduledTask:
    """Recordings that a worker decodes, by their indexes."""

    numbers: tuple[int, ...]
    again: bool = False  # whether a worker died of it already


class Scheduler:
    """Decodes recordings by an executor; made once for each input."""

    def __init__(
        self,
        executor: Executor,
        names: Sequence[str],
        numbers: Sequence[int],
        limit: float | None = None,
    ) -> None:
        """Begin with nothing done.

        `numbers` are the indexes of the names to be decoded. The limit is for a recording, s; None
        is its length and a minute.
        """
        self._executor, self._names, self._limit = executor, names, limit
        self._left = deque(numbers)
        self._first: deque[ScheduledTask] = deque()  # before all others
        self._alone: deque[ScheduledTask] = deque()  # with nothing else running
        self._ended: SimpleQueue[tuple[ScheduledTask, Future[tuple[Outcome, ...]]]] = SimpleQueue()

    def run(self) -> Iterator[Finished]:
        """Decode; yields the outcomes as they come."""
        under_way = 0
        while True:
            while under_way < QUEUED_PER_WORKER * self._executor.size and (task := self._next()):
                self._submit(task)
                under_way += 1
            if not under_way:
                if not self._alone:
                    return
                # Else other tasks would be blamed for the death of their workers, too.
                self._submit(self._alone.popleft())
                under_way = 1
            task, future = self._ended.get()
            under_way -= 1
            yield from self._take(task, future)

    def _next(self) -> ScheduledTask | None:
        """The next task: a suspicious recording, or some new ones."""
        if self._first:
            return self._first.popleft()
        most = max(
            1, min(MOST_FILES_PER_TASK, len(self._left) // (TASKS_PER_WORKER * self._executor.size))
        )
        numbers: list[int] = []
        size = 0
        while self._left and len(numbers) < most and size < self._executor.batch_bytes:
            numbers.append(self._left.popleft())
            size += size_of(self._names[numbers[-1]])
        return ScheduledTask(tuple(numbers)) if numbers else None

    def _submit(self, task: ScheduledTask) -> None:
        names = [self._names[number] for number in task.numbers]
        future = self._executor.submit(names, self._limit_for(names))
        future.add_done_callback(lambda done: self._ended.put((task, done)))

    def _limit_for(self, names: Sequence[str]) -> float:
        if self._limit is not None:
            return self._limit
        return 60.0 + sum(map(size_of, names)) / LEAST_BYTES_PER_SECOND

    def _take(self, task: ScheduledTask, future: Future[tuple[Outcome, ...]]) -> Iterator[Finished]:
        """Handle a task that has ended, one way or the other."""
        try:
            outcomes = future.result()
        except TimeoutError:
            yield from self._suspect(task, "takes too long; raise --time-limit", again=False)
        except WorkerDied as death:
            said = f"made its worker end twice ({death}); leave it out, or raise --memory-limit"
            yield from self._suspect(task, said, again=not task.again)
        else:
            yield from map(Finished, task.numbers, outcomes)

    def _suspect(self, task: ScheduledTask, said: str, again: bool) -> Iterator[Finished]:
        """Retry what a worker died of: each recording alone, then with nothing else running."""
        if len(task.numbers) > 1:
            self._first.extend(ScheduledTask((number,)) for number in task.numbers)
        elif again:
            self._alone.append(ScheduledTask(task.numbers, again=True))
        else:
            (number,) = task.numbers
            name = self._names[number]
            error = f"{shown_name(name)}: {said}"
            yield Finished(number, failed_outcome(shown_name(name), error, stamp_of(name)))


def size_of(name: str) -> int:
    """The size of a recording, bytes; assumed of one at an address, 0 if it is missing."""
    if is_remote(name):
        return REMOTE_SIZE_BYTES
    try:
        return Path(name).stat().st_size
    except (OSError, ValueError):
        return 0
