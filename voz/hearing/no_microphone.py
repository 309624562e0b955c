"""In place of a microphone, where a robot has none."""

from __future__ import annotations

import time
from collections.abc import Iterator
from contextlib import nullcontext

from voz.audio import Samples
from voz.audio.segment import NO_SAMPLES
from voz.hearing.microphone_thread import SoundSource

POLL_INTERVAL = 0.1
"""How often the thread that listens looks for its end, s."""


class NoMicrophone:
    """An `OpenMicrophone` that hears nothing, and is never lost."""

    name = "none"
    blocks_lost = 0
    whole = addressed = False

    def __init__(self) -> None:
        self.arrived = time.monotonic()

    @property
    def alive(self) -> float:
        """Now, on the monotonic clock, s."""
        return time.monotonic()

    @alive.setter
    def alive(self, when: float) -> None:
        pass

    def __iter__(self) -> Iterator[Samples]:
        return self

    def __next__(self) -> Samples:
        time.sleep(POLL_INTERVAL)
        self.arrived = time.monotonic()
        return NO_SAMPLES


def no_sound() -> SoundSource:
    """Return a source of no sound."""
    return SoundSource(lambda: nullcontext(NoMicrophone()))
