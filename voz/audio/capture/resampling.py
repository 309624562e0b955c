"""Resampling to 16 kHz, block by block."""

from __future__ import annotations

from typing import Any

import numpy as np
import numpy.typing as npt

from voz.audio import SAMPLE_RATE, Samples
from voz.audio.capture.sound_files import to_int16

Mono = npt.NDArray[np.float32]


class Resampler:
    """Converts a stream of floats from -1 to 1 to `Samples`."""

    def __init__(self, rate: float) -> None:
        """Start a stream of this rate, Hz."""
        self._stream: Any = None
        if rate != SAMPLE_RATE:
            import soxr  # takes 20 ms, and 16 kHz needs none

            self._stream = soxr.ResampleStream(rate, SAMPLE_RATE, 1, dtype="float32")

    def feed(self, block: Mono) -> Samples:
        """Convert the next block; the resampler may keep its last samples for later."""
        return to_int16(self._stream.resample_chunk(block) if self._stream else block)

    def finish(self) -> Samples:
        """End the stream; returns its last samples."""
        nothing = np.empty(0, np.float32)
        return to_int16(
            self._stream.resample_chunk(nothing, last=True) if self._stream else nothing
        )
