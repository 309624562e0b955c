"""Many recordings in a program of one's own, and what a worker dies of costs no other recording."""

from __future__ import annotations

import subprocess
import sys
from collections.abc import Iterator, Sequence
from concurrent.futures import Future
from contextlib import contextmanager
from pathlib import Path
from queue import Empty, SimpleQueue
from threading import Thread

import numpy as np
import pytest
import soundfile
from hypothesis import given
from hypothesis import strategies as st
from recordings import FIXTURES, GO_BACK

import voz
from voz.apps.batch.batch_decoder import Scheduler
from voz.apps.batch.outcomes import Outcome, SilentRow
from voz.process.worker_pool import WorkerDied

PROGRAM = """
import sys, voz
print("begun")
for recording in voz.decode_many(sys.argv[1:], jobs=2):
    print(recording.file, *recording.utterances, recording.error, sep="|")
"""


@pytest.mark.slow
def test_a_program_decodes_on_all_cores_and_is_begun_once(tmp_path: Path) -> None:
    program, bad = tmp_path / "program.py", tmp_path / "bad.wav"
    program.write_text(PROGRAM)  # which has no `if __name__ == "__main__"`
    bad.write_text("no recording")
    recordings = [*sorted((FIXTURES / "commands").glob("festival_kal__*.flac")), bad]
    command = [sys.executable, str(program), *map(str, recordings)]
    done = subprocess.run(command, capture_output=True, text=True, check=True)
    first, *lines, last = done.stdout.splitlines()
    assert first == "begun"
    said = [path.stem.removeprefix("festival_kal__").replace("_", " ") for path in recordings[:-1]]
    assert lines == [f"{p}|{s}|None" for p, s in zip(recordings, said, strict=False)]
    assert last.startswith(f"{bad}|{bad}: ")
    assert done.stderr == ""


def test_utterances_are_those_of_a_recognizer_with_the_same_list(tmp_path: Path) -> None:
    commands = ["go back", "go [far] forward"]
    (decoded,) = voz.decode_many(GO_BACK, commands)
    (heard,) = decoded.utterances
    (tmp_path / "list.txt").write_text("\n".join(commands))
    assert list(voz.decode_many(GO_BACK, tmp_path / "list.txt")) == [decoded]
    (known,) = voz.load(commands).decode(GO_BACK)
    assert heard
    assert (str(heard), heard.confidence, heard.score) == ("go back", known.confidence, known.score)
    assert (decoded.file, decoded.error) == (str(GO_BACK), None)
    assert decoded.seconds > 0.5


def test_what_is_left_out_or_read_otherwise_is_in_the_log(
    tmp_path: Path, caplog: pytest.LogCaptureFixture
) -> None:
    sound, rate = soundfile.read(GO_BACK)
    soundfile.write(tmp_path / "a.wav", np.stack([sound, -sound], axis=1), rate)
    (tmp_path / "b.m4a").touch()
    (decoded,) = voz.decode_many(tmp_path)
    assert list(map(str, decoded.utterances)) == ["go back"]
    left_out, phase = caplog.messages
    assert left_out.startswith(f"left out, as voz does not read the format: {tmp_path}/b.m4a; ")
    assert phase.startswith(f"{tmp_path}/a.wav: its channels are out of phase")


def test_what_is_no_recording_is_said() -> None:
    with pytest.raises(voz.ConfigError, match="Expected `str`, got `int` - at `recordings`"):
        list(voz.decode_many([3]))  # type: ignore[list-item]
    (decoded,) = voz.decode_many("none.wav")
    assert decoded.error == "none.wav: there is no such file"


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
