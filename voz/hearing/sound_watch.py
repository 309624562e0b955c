"""Warns of a muted microphone, and of lost sound."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from voz.audio import SAMPLE_RATE, Samples
from voz.audio.microphone import MICROPHONE_BLOCK_SECONDS
from voz.events import Notice
from voz.inbox import Inbox

MUTED_AFTER = 5.0
"""A microphone that gives only zeros for this time is muted, s; no room is so quiet."""

MUTED_AFTER_IN_MOTION = 0.35
"""The same while the robot moves, s; with the beat, 0.5 s."""

LOSS_WARNING_INTERVAL = 5.0
"""Between two warnings of lost sound, s."""

ONLY_SILENCE = "the microphone gives only silence"

MUTE_WARNING = f"{ONLY_SILENCE}: is it muted? `voz devices --test` shows it"


class SilenceCheck:
    """Whether a muted microphone stops the robot: once the robot moves, and from then on."""

    def __init__(self) -> None:
        self._matters = False

    def trouble(self, silent: bool, moving: bool) -> str | None:
        """Return what is wrong, if the microphone is silent and the robot moves or has moved."""
        self._matters = silent and (moving or self._matters)
        return ONLY_SILENCE if self._matters else None


class SoundWatch:
    """Warns of a muted microphone, and of lost sound.

    Attributes:
        zeros: how long the microphone has given only zeros, s.
    """

    def __init__(self, inbox: Inbox, clock: Callable[[], float]) -> None:
        """Start a stream; warnings go into `inbox` with the time of `clock`, s."""
        self._inbox = inbox
        self._clock = clock
        self._blocks_lost = 0
        self._loss_told = -LOSS_WARNING_INTERVAL  # when
        self.zeros = 0.0

    def check(self, block: Samples, blocks_lost: int) -> float:
        """Check a block, and the number of lost blocks so far; returns its peak, 0 to 1."""
        now = self._clock()
        if blocks_lost > self._blocks_lost and now - self._loss_told >= LOSS_WARNING_INTERVAL:
            seconds = (blocks_lost - self._blocks_lost) * MICROPHONE_BLOCK_SECONDS
            self._blocks_lost, self._loss_told = blocks_lost, now
            self._warn(f"{seconds:.2f} s of sound were lost: the computer is too slow")
        peak = float(np.abs(block).max(initial=0)) / 32768
        before = self.zeros
        self.zeros = 0.0 if peak else before + len(block) / SAMPLE_RATE
        if before < MUTED_AFTER <= self.zeros:
            self._warn(MUTE_WARNING)
        return peak

    def _warn(self, text: str) -> None:
        self._inbox.put(Notice(round(self._clock(), 3), text))
