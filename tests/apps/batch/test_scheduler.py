"""What a worker dies of costs no other recording, whoever else its death is blamed on."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from concurrent.futures import Future
from contextlib import contextmanager
from queue import Empty, SimpleQueue
from threading import Thread

from hypothesis import given
from hypothesis import strategies as st

from voz.apps.batch.outcomes import Outcome, SilentRow
from voz.apps.batch.scheduler import Scheduler
from voz.process.worker_pool import WorkerDied

Given = tuple[Future[tuple[Outcome, ...]], Sequence[str]]


class Blaming:
    """A pool in which a recording that is called poison costs all that is under way."""

    batch_bytes = 10_000_000

    def __init__(self, size: int) -> None:
        self.size = size
        self.given: SimpleQueue[Given | None] = SimpleQueue()

    def submit(self, names: Sequence[str], limit: float | None) -> Future[tuple[Outcome, ...]]:
        future: Future[tuple[Outcome, ...]] = Future()
        self.given.put((future, names))
        return future

    def work(self) -> None:
        while (first := self.given.get()) is not None:
            under_way = [first, *self._others()]
            fatal = any("poison" in name for _, names in under_way for name in names)
            for future, names in under_way:
                if fatal:
                    future.set_exception(WorkerDied("by poison"))
                else:
                    future.set_result(tuple(Outcome((SilentRow(n, 1.0),)) for n in names))

    def _others(self) -> Iterator[Given]:
        while True:
            try:
                other = self.given.get(timeout=0.002)
            except Empty:
                return
            assert other
            yield other


@contextmanager
def blaming(size: int) -> Iterator[Blaming]:
    pool = Blaming(size)
    thread = Thread(target=pool.work)
    thread.start()
    yield pool
    pool.given.put(None)
    thread.join()


@given(st.lists(st.booleans(), min_size=1, max_size=30), st.integers(1, 3))
def test_only_what_kills_has_failed_and_each_is_told_of_once(poison: list[bool], size: int) -> None:
    names = [f"{number} {'poison' if bad else 'good'}" for number, bad in enumerate(poison)]
    with blaming(size) as pool:
        known = list(Scheduler(pool, names, range(len(names))).run())
    assert sorted(number for number, _ in known) == list(range(len(names)))
    assert {number for number, outcome in known if outcome.failed} == {
        number for number, bad in enumerate(poison) if bad
    }
