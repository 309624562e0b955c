"""One recognizer, called by several threads."""

from __future__ import annotations

import os
import signal
import subprocess
import sys
from collections.abc import Iterator
from concurrent.futures import ThreadPoolExecutor
from itertools import islice
from threading import Barrier, BrokenBarrierError, Thread

import numpy as np
import pytest
from recordings import ROOT, Recording

from voz.api.recognizer import Recognizer
from voz.audio import Samples
from voz.audio.sound_files import read_blocks, read_samples
from voz.errors import RecognizerBusyError
from voz.events import Utterance
from voz.process.call_lock import NonReentrantLock
from voz.recognition import finders

FORKS = """
import os, signal, sys, threading
import soundfile, voz

recognizer = voz.load("lm", voz.Recognition(use_network=sys.argv[1] == "network"))
sound, rate = soundfile.read(sys.argv[2], dtype="int16")
alone = [heard.text for heard in recognizer.decode(sound, rate)]
listener = recognizer.listen(rate)
over = threading.Event()

def decode():
    while not over.is_set():
        recognizer.decode(sound, rate)

def feed():
    while not over.is_set():
        listener.feed(sound)

threads = [threading.Thread(target=work) for work in (decode, decode, feed)]
for thread in threads:
    thread.start()
codes = []
for _ in range(6):
    child = os.fork()
    if not child:
        signal.alarm(60)  # who waits for ever is killed
        listener.feed(sound)
        heard = [heard.text for heard in recognizer.decode(sound, rate)]
        os._exit(0 if heard == alone == ["go forward"] else 1)
    codes.append(os.waitstatus_to_exitcode(os.waitpid(child, 0)[1]))
over.set()
for thread in threads:
    thread.join()
print(codes)
"""


@pytest.fixture(scope="module")
def sounds(recordings: list[Recording]) -> list[Samples]:
    clips = [r for r in recordings if r.kind == "command"][::60]
    return [read_samples(r.path) for r in clips]


def test_threads_that_decode_hear_what_each_would_hear_alone(
    recognizer: Recognizer, sounds: list[Samples]
) -> None:
    alone = [recognizer.decode(sound, 16000) for sound in sounds]
    assert any(alone)
    together = Barrier(4)

    def decode_all(_: int) -> list[list[Utterance]]:
        together.wait()
        return [recognizer.decode(sound, 16000) for sound in sounds]

    with ThreadPoolExecutor(4) as threads:
        for heard in threads.map(decode_all, range(4)):
            assert heard == alone


def test_a_stream_and_a_generator_do_not_keep_others_waiting(
    recognizer: Recognizer, session: Recording, sounds: list[Samples]
) -> None:
    def halves(sound: Samples) -> Iterator[Samples]:
        yield sound[: len(sound) // 2]
        # In the midst of the recording, as its next block is asked for.
        between.extend(recognizer.decode(sounds[0], 16000))
        yield sound[len(sound) // 2 :]

    alone = [*recognizer.utterances(read_blocks(session.path), "")]
    between: list[Utterance] = []
    generator = recognizer.utterances(halves(session.samples()), "")
    heard = [*islice(generator, 1)]
    listener = recognizer.listen(16000)
    listener.feed(sounds[0])
    other = Thread(target=lambda: between.extend(recognizer.decode(sounds[0], 16000)))
    other.start()
    other.join()
    listener.finish()
    heard += generator
    assert [u.text for u in heard] == [u.text for u in alone]
    assert between == recognizer.decode(sounds[0], 16000) * 2


def test_threads_that_feed_one_stream_take_turns(recognizer: Recognizer) -> None:
    met: list[bool] = []

    class Sound:
        together = Barrier(2)

        def __array__(self, *_: object, **__: object) -> Samples:
            try:
                self.together.wait(0.2)
                met.append(True)
            except BrokenBarrierError:
                met.append(False)
            return np.zeros(1600, np.int16)

    listener = recognizer.listen(16000)
    with ThreadPoolExecutor(2) as threads:
        assert [*threads.map(listener.feed, [Sound(), Sound()])] == [[], []]
    assert met == [False, False]


def test_a_signal_handler_gets_an_error_and_does_not_wait_for_ever(
    recognizer: Recognizer, sounds: list[Samples], monkeypatch: pytest.MonkeyPatch
) -> None:
    denoise = finders.denoise_if_noisy
    refused: list[str] = []

    def interrupted(samples: Samples) -> Samples:
        signal.raise_signal(signal.SIGUSR1)
        return denoise(samples)

    def handler(*_: object) -> None:
        with pytest.raises(RecognizerBusyError) as raised:
            recognizer.decode(sounds[0], 16000)
        refused.append(str(raised.value))

    before = signal.signal(signal.SIGUSR1, handler)
    monkeypatch.setattr(finders, "denoise_if_noisy", interrupted)
    try:
        heard = recognizer.decode(sounds[0], 16000)
    finally:
        signal.signal(signal.SIGUSR1, before)
    monkeypatch.undo()
    assert refused[0].startswith("a signal handler calls the recognizer")
    assert heard == recognizer.decode(sounds[0], 16000)


def test_what_was_refused_lets_the_next_call_in() -> None:
    turns = NonReentrantLock()
    with turns, pytest.raises(RecognizerBusyError), turns:
        raise AssertionError
    with turns:
        pass


@pytest.mark.slow
@pytest.mark.parametrize("finder", ["network", "pocketsphinx"])
def test_a_fork_amid_calls_of_other_threads_leaves_a_child_that_decodes(
    finder: str, recordings: list[Recording]
) -> None:
    sound = next(r.path for r in recordings if "go_forward" in r.path.name)
    command = [sys.executable, "-W", "ignore", "-c", FORKS, finder, str(sound)]
    done = subprocess.run(command, cwd=ROOT, capture_output=True, text=True)
    assert (done.stdout, done.stderr) == ("[0, 0, 0, 0, 0, 0]\n", "")


@pytest.mark.filterwarnings("ignore:.*multi-threaded:DeprecationWarning")
def test_a_fork_in_a_signal_handler_amid_a_call_waits_for_nobody() -> None:
    turns = NonReentrantLock()
    with turns:
        child = os.fork()
        if not child:
            os._exit(0)
        assert os.waitstatus_to_exitcode(os.waitpid(child, 0)[1]) == 0
    with turns:
        pass
