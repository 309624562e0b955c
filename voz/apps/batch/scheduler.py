"""Hands recordings out to workers, and takes care of those that a worker dies of."""

from __future__ import annotations

from collections import deque
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from queue import SimpleQueue
from typing import Any, NamedTuple

from voz.apps.batch.executors import Executor, TaskTimeout
from voz.apps.batch.long_recordings import (
    CutPlan,
    DecodedPart,
    first_mismatch,
    outcome_of_parts,
    parts_of,
    without_cut,
)
from voz.apps.batch.outcomes import Outcome, failed_outcome
from voz.apps.batch.remote import is_remote, shown_name
from voz.apps.batch.stamps import stamp_of
from voz.apps.batch.tasks import BatchTask, CutTask, DecodeTask, PartTask
from voz.errors import AudioError
from voz.process.worker_pool import WorkerDied

MOST_FILES_PER_TASK = 1000
"""Handed out at once, however small they are."""

REMOTE_SIZE_BYTES = 500_000
"""Taken for that of a recording elsewhere, bytes."""

TASKS_PER_WORKER = 4
"""Tasks of what is left for each worker: the last ones are small, so none waits for another."""

QUEUED_PER_WORKER = 2
"""Tasks for each worker: it never waits for the next one."""


class Finished(NamedTuple):
    """What is known of a recording: its place in the input, and the outcome."""

    number: int
    outcome: Outcome


@dataclass(frozen=True)
class ScheduledTask:
    """A task that somebody does.

    Attributes:
        task: what to do.
        numbers: the recordings in it, by their place in the input.
        again: whether it is done for the second time, after a worker died of it.
    """

    task: BatchTask
    numbers: tuple[int, ...]
    again: bool = False


@dataclass
class CutRecording:
    """A long recording whose parts are under way.

    Attributes:
        plan: how it is cut.
        done: the parts that are done, by where they begin.
    """

    plan: CutPlan
    done: dict[int, DecodedPart] = field(default_factory=dict)


class Scheduler:
    """Decodes recordings by a pool; made once for each input."""

    def __init__(
        self,
        pool: Executor,
        names: Sequence[str],
        numbers: Sequence[int],
        limit: float | None = None,
    ) -> None:
        """Begin with nothing done.

        Args:
            pool: who decodes.
            names: of all recordings.
            numbers: which of them are to be decoded.
            limit: how long one recording, or a part of a long one, may take, s; None for as long
                as it lasts, and a minute.
        """
        self._pool, self._names, self._limit = pool, names, limit
        self._left = deque(numbers)
        self._first: deque[ScheduledTask] = deque()  # what goes before all others
        self._last: deque[ScheduledTask] = deque()  # what is tried with nothing beside it
        self._cut: dict[int, CutRecording] = {}
        self._ended: SimpleQueue[tuple[ScheduledTask, Any]] = SimpleQueue()

    def run(self) -> Iterator[Finished]:
        """Decode; yields the outcomes as they come."""
        under_way = 0
        while True:
            while under_way < QUEUED_PER_WORKER * self._pool.size and (asked := self._next()):
                self._submit(asked)
                under_way += 1
            if not under_way:
                if not self._last:
                    return
                # What else its workers had would be blamed for their deaths, too.
                self._submit(self._last.popleft())
                under_way = 1
            asked, future = self._ended.get()
            under_way -= 1
            yield from self._take(asked, future)

    def _next(self) -> ScheduledTask | None:
        """The next task: what is left of a long or suspicious recording, or a few new ones."""
        if self._first:
            return self._first.popleft()
        most = max(
            1, min(MOST_FILES_PER_TASK, len(self._left) // (TASKS_PER_WORKER * self._pool.size))
        )
        numbers: list[int] = []
        size = 0
        while self._left and len(numbers) < most and size < self._pool.batch:
            numbers.append(self._left.popleft())
            size += _size(self._names[numbers[-1]])
        return self._files(numbers) if numbers else None

    def _files(
        self, numbers: Sequence[int], cut: bool = True, again: bool = False
    ) -> ScheduledTask:
        names = tuple(self._names[number] for number in numbers)
        return ScheduledTask(DecodeTask(names, cut and self._pool.size > 1), tuple(numbers), again)

    def _submit(self, asked: ScheduledTask) -> None:
        future = self._pool.submit(asked.task, self._limit_for(asked))
        future.add_done_callback(lambda done: self._ended.put((asked, done)))

    def _limit_for(self, asked: ScheduledTask) -> float:
        if self._limit is not None:
            return self._limit
        names = [self._names[number] for number in asked.numbers]
        return 60.0 + sum(_size(name) for name in names) / LEAST_BYTES_PER_SECOND

    def _take(self, asked: ScheduledTask, future: Any) -> Iterator[Finished]:
        """Go on from a task that has ended, one way or the other."""
        try:
            result = self._pool.result(future)
        except TaskTimeout:
            yield from self._suspect(asked, "takes too long; raise --time-limit", again=False)
        except WorkerDied as death:
            said = f"made its worker end twice ({death}); leave it out, or raise --memory-limit"
            yield from self._suspect(asked, said, again=not asked.again)
        except AudioError as error:
            yield from self._failed(asked, str(error))
        else:
            if isinstance(result, tuple):
                yield from self._heard(asked, result)
            elif isinstance(result, DecodedPart):
                yield from self._part_done(asked, result)
            else:
                self._begin_parts(asked.numbers[0], result)

    def _heard(
        self, asked: ScheduledTask, outcomes: Sequence[Outcome | None]
    ) -> Iterator[Finished]:
        for number, outcome in zip(asked.numbers, outcomes, strict=True):
            if outcome is None:
                self._first.append(ScheduledTask(CutTask(self._names[number]), (number,)))
            else:
                yield Finished(number, outcome)

    def _suspect(self, asked: ScheduledTask, said: str, again: bool) -> Iterator[Finished]:
        """Try what a worker died of again: by itself, and then with nothing else under way."""
        if len(asked.numbers) > 1:
            self._first.extend(self._files([number]) for number in asked.numbers)
        elif again:
            self._last.append(ScheduledTask(asked.task, asked.numbers, again=True))
        else:
            number = asked.numbers[0]
            yield from self._failed(asked, f"{shown_name(self._names[number])}: {said}")

    def _failed(self, asked: ScheduledTask, error: str) -> Iterator[Finished]:
        """Give a recording up; of a long one other parts may still be under way."""
        for number in asked.numbers:
            if isinstance(asked.task, PartTask) and self._cut.pop(number, None) is None:
                continue
            self._first = deque(one for one in self._first if one.numbers != (number,))
            self._last = deque(one for one in self._last if one.numbers != (number,))
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

    def _part_done(self, asked: ScheduledTask, done: DecodedPart) -> Iterator[Finished]:
        (number,) = asked.numbers
        cut = self._cut.get(number)
        if cut is None or not isinstance(asked.task, PartTask):
            return
        cut.done[asked.task.part.start] = done
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


LEAST_BYTES_PER_SECOND = 4000
"""Bytes of a recording for each second that it may take at least: few are compressed to less."""


def _size(name: str) -> int:
    if is_remote(name):
        return REMOTE_SIZE_BYTES
    try:
        return Path(name).stat().st_size
    except (OSError, ValueError):
        return 0
