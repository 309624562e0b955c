"""Hands recordings out to workers, and isolates those that workers die of."""

from __future__ import annotations

from collections import deque
from collections.abc import Iterator, Sequence
from concurrent.futures import Future, TimeoutError
from dataclasses import dataclass, field
from pathlib import Path
from queue import SimpleQueue
from typing import NamedTuple

from voz.apps.batch.executors import Executor
from voz.apps.batch.locations import is_remote, shown_name
from voz.apps.batch.long_recordings import (
    CutPlan,
    DecodedPart,
    first_mismatch,
    outcome_of_parts,
    parts_of,
    without_cut,
)
from voz.apps.batch.outcomes import Outcome, failed_outcome
from voz.apps.batch.stamps import stamp_of
from voz.apps.batch.worker import BatchTask, CutTask, DecodeTask, PartTask, TaskResult
from voz.errors import AudioError
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
    """A task that somebody does."""

    task: BatchTask
    numbers: tuple[int, ...]  # the indexes of its recordings
    again: bool = False  # whether a worker died of it already


@dataclass
class CutRecording:
    """A long recording whose parts are under way."""

    plan: CutPlan
    done: dict[int, DecodedPart] = field(default_factory=dict)  # by the start of the part


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

        Args:
            executor: who decodes.
            names: of all recordings.
            numbers: the indexes of those to be decoded.
            limit: for a recording or a part of it, s; None for its length and a minute.
        """
        self._executor, self._names, self._limit = executor, names, limit
        self._left = deque(numbers)
        self._first: deque[ScheduledTask] = deque()  # before all others
        self._alone: deque[ScheduledTask] = deque()  # with nothing else running
        self._cut: dict[int, CutRecording] = {}
        self._ended: SimpleQueue[tuple[ScheduledTask, Future[TaskResult]]] = SimpleQueue()

    def run(self) -> Iterator[Finished]:
        """Decode; yields the outcomes as they come."""
        under_way = 0
        while True:
            while under_way < QUEUED_PER_WORKER * self._executor.size and (
                scheduled := self._next()
            ):
                self._submit(scheduled)
                under_way += 1
            if not under_way:
                if not self._alone:
                    return
                # Else other tasks would be blamed for the death of their workers, too.
                self._submit(self._alone.popleft())
                under_way = 1
            scheduled, future = self._ended.get()
            under_way -= 1
            yield from self._take(scheduled, future)

    def _next(self) -> ScheduledTask | None:
        """The next task: of a long or suspicious recording, or some new ones."""
        if self._first:
            return self._first.popleft()
        most = max(
            1, min(MOST_FILES_PER_TASK, len(self._left) // (TASKS_PER_WORKER * self._executor.size))
        )
        numbers: list[int] = []
        size = 0
        while self._left and len(numbers) < most and size < self._executor.batch_bytes:
            numbers.append(self._left.popleft())
            size += _size(self._names[numbers[-1]])
        return self._files(numbers) if numbers else None

    def _files(
        self, numbers: Sequence[int], cut: bool = True, again: bool = False
    ) -> ScheduledTask:
        names = tuple(self._names[number] for number in numbers)
        return ScheduledTask(
            DecodeTask(names, cut and self._executor.size > 1), tuple(numbers), again
        )

    def _submit(self, scheduled: ScheduledTask) -> None:
        future = self._executor.submit(scheduled.task, self._limit_for(scheduled))
        future.add_done_callback(lambda done: self._ended.put((scheduled, done)))

    def _limit_for(self, scheduled: ScheduledTask) -> float:
        if self._limit is not None:
            return self._limit
        names = [self._names[number] for number in scheduled.numbers]
        return 60.0 + sum(_size(name) for name in names) / LEAST_BYTES_PER_SECOND

    def _take(self, scheduled: ScheduledTask, future: Future[TaskResult]) -> Iterator[Finished]:
        """Handle a task that has ended, one way or the other."""
        try:
            result = future.result()
        except TimeoutError:
            yield from self._suspect(scheduled, "takes too long; raise --time-limit", again=False)
        except WorkerDied as death:
            said = f"made its worker end twice ({death}); leave it out, or raise --memory-limit"
            yield from self._suspect(scheduled, said, again=not scheduled.again)
        except AudioError as error:
            yield from self._failed(scheduled, str(error))
        else:
            if isinstance(result, tuple):
                yield from self._heard(scheduled, result)
            elif isinstance(result, DecodedPart):
                yield from self._part_done(scheduled, result)
            else:
                self._begin_parts(scheduled.numbers[0], result)

    def _heard(
        self, scheduled: ScheduledTask, outcomes: Sequence[Outcome | None]
    ) -> Iterator[Finished]:
        for number, outcome in zip(scheduled.numbers, outcomes, strict=True):
            if outcome is None:
                self._first.append(ScheduledTask(CutTask(self._names[number]), (number,)))
            else:
                yield Finished(number, outcome)

    def _suspect(self, scheduled: ScheduledTask, said: str, again: bool) -> Iterator[Finished]:
        """Retry what a worker died of: each recording alone, then with nothing else running."""
        if len(scheduled.numbers) > 1:
            self._first.extend(self._files([number]) for number in scheduled.numbers)
        elif again:
            self._alone.append(ScheduledTask(scheduled.task, scheduled.numbers, again=True))
        else:
            number = scheduled.numbers[0]
            yield from self._failed(scheduled, f"{shown_name(self._names[number])}: {said}")

    def _failed(self, scheduled: ScheduledTask, error: str) -> Iterator[Finished]:
        """Give a recording up; other parts of it may still be running."""
        for number in scheduled.numbers:
            if isinstance(scheduled.task, PartTask) and self._cut.pop(number, None) is None:
                continue
            self._first = deque(one for one in self._first if one.numbers != (number,))
            self._alone = deque(one for one in self._alone if one.numbers != (number,))
            name = self._names[number]
            yield Finished(number, failed_outcome(shown_name(name), error, stamp_of(name)))

    def _begin_parts(self, number: int, plan: CutPlan | None) -> None:
        if plan is None:
            self._first.append(self._files([number], cut=False))
            return
        self._cut[number] = CutRecording(plan)
        self._first.extend(self._part(number, index) for index in range(len(plan.cuts) - 1))

    def _part(self, number: int, index: int) -> ScheduledTask:
        part = parts_of(self._cut[number].plan)[index]
        return ScheduledTask(PartTask(self._names[number], part), (number,))

    def _part_done(self, scheduled: ScheduledTask, done: DecodedPart) -> Iterator[Finished]:
        (number,) = scheduled.numbers
        cut = self._cut.get(number)
        if cut is None or not isinstance(scheduled.task, PartTask):
            return
        cut.done[scheduled.task.part.start] = done
        starts = cut.plan.cuts[:-1]
        if len(cut.done) < len(starts):
            return
        parts = [cut.done[start] for start in starts]
        wrong = first_mismatch(parts)
        if wrong is None:
            del self._cut[number]
            yield Finished(
                number, outcome_of_parts(shown_name(self._names[number]), parts, cut.plan.stamp)
            )
        else:
            cut.plan = without_cut(cut.plan, wrong)
            del cut.done[starts[wrong]], cut.done[starts[wrong + 1]]
            self._first.append(self._part(number, wrong))


def _size(name: str) -> int:
    if is_remote(name):
        return REMOTE_SIZE_BYTES
    try:
        return Path(name).stat().st_size
    except (OSError, ValueError):
        return 0
