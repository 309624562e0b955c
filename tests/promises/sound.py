"""What is said, as samples, and a microphone that hears it as a stepped time goes on."""

from __future__ import annotations

import functools
import queue
import threading
from collections.abc import Iterator

import numpy as np
from promises.fake_time import Timeline
from recordings import spoken

from voz.audio import SAMPLE_RATE, Samples
from voz.errors import AudioError

BLOCK_SECONDS = 0.03
BLOCK = int(BLOCK_SECONDS * SAMPLE_RATE)

WORKED = 60.0
"""A thread that has not heard a block by then has died, real seconds."""


UNSURE = "go forward?"
"""What is heard so that a robot which asks back asks "did you say go forward?"."""


@functools.cache
def speech(text: str) -> Samples:
    """A sentence by a voice of festival that is understood."""
    if text == UNSURE:  # somebody else says another command at the same time
        one, other = speech("go forward"), speech("go back")
        both = np.zeros(max(len(one), len(other)))
        both[: len(one)] += 0.44 * one
        both[: len(other)] += 0.56 * other
        return both.astype(np.int16)
    return spoken(text, "cmu_us_slt_arctic_hts")


class Room:
    """The sound of a quiet room, in which somebody speaks now and then."""

    def __init__(self) -> None:
        self.muted = False  # whether the microphone in it gives only zeros
        self._noise = np.random.default_rng(0)
        self._said = np.zeros(0)

    @property
    def silent(self) -> bool:
        """Whether all that was said is over."""
        return not len(self._said)

    def say(self, text: str) -> None:
        """Say a sentence from now on, after what is being said."""
        self._said = np.concatenate([self._said, speech(text)])

    def take(self, samples: int) -> Samples:
        """Return what is heard next."""
        heard = self._noise.normal(0, 8, samples)
        said, self._said = self._said[:samples], self._said[samples:]
        heard[: len(said)] += said
        return heard.clip(-32768, 32767).astype(np.int16) * (not self.muted)


class SteppedMicrophone:
    """An `OpenMicrophone` in a room: the thread that hears takes each block before time goes on."""

    name = "of the test"
    complete = True
    addressed = False
    blocks_lost = 0
    out_of_phase = False

    def __init__(self, timeline: Timeline) -> None:
        self._timeline = timeline
        self.arrived = timeline.now
        self.alive = timeline.now
        self.room = Room()
        self.lost = False
        self._over = False
        self._next = timeline.now
        self._blocks: queue.SimpleQueue[Samples | None] = queue.SimpleQueue()
        self._waits = threading.Semaphore(0)

    def step(self) -> None:
        """Hand over the block that is due."""
        if self._timeline.now < self._next:
            return
        self._next = max(self._next, self._timeline.now - BLOCK_SECONDS) + BLOCK_SECONDS
        block = self.room.take(BLOCK)
        if self.lost or not self._waits.acquire(timeout=WORKED):
            return
        self.arrived = self._timeline.now
        self.alive = self._timeline.now
        self._blocks.put(block)
        # It has worked when it waits again.
        assert self._waits.acquire(timeout=WORKED), "the thread that hears has died"
        self._waits.release()

    def close(self) -> None:
        """Give no more."""
        self._over = True
        self._blocks.put(None)

    def __iter__(self) -> Iterator[Samples]:
        return self

    def __next__(self) -> Samples:
        self._waits.release()
        block = None if self._over else self._blocks.get()
        if block is None:
            raise AudioError("the microphone of the test is over")
        return block


class SilentMicrophone(SteppedMicrophone):
    """One that hears nothing and is never lost, as of a run that needs none."""

    @property
    def alive(self) -> float:
        """Now."""
        return self._timeline.now

    @alive.setter
    def alive(self, when: float) -> None:
        pass
