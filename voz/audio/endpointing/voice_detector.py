"""Whether a sound is speech, by the Silero network."""

from __future__ import annotations

from functools import cache

import numpy as np

from voz.audio import Samples
from voz.audio.endpointing.silero import SILERO_BLOCK, Silero

RUN_UP = 2 * SILERO_BLOCK
"""Samples before the words; a voice that begins out of nothing is often no speech to it."""

AVERAGED_BLOCKS = 6
"""Blocks, 0.2 s, whose mean probability counts; it separates commands from noises best."""

EXAMINED_BLOCKS = 16
"""Blocks, half a second, in which a word of speech is recognized as such."""


class VoiceDetector:
    """Computes the probability that a sound is speech."""

    def __init__(self) -> None:
        """Load the network; raises AudioError if it is not installed."""
        self._network = Silero()

    def probability(self, samples: Samples) -> float:
        """Return the highest mean probability of speech over 0.2 s, 0 to 1.

        The samples, 16 kHz, have a run-up before the words; less than 32 ms give 0.
        """
        found = self._network.probabilities(samples[: EXAMINED_BLOCKS * SILERO_BLOCK])
        if not len(found):
            return 0.0
        length = min(AVERAGED_BLOCKS, len(found))
        sums = np.convolve(found, np.ones(length), mode="valid")
        return float(np.max(sums)) / length


@cache
def shared_voice_detector() -> VoiceDetector:
    """One detector for all; it has no state."""
    return VoiceDetector()
