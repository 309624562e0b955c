"""The sound of clips that went wrong, as the engine heard it."""

from __future__ import annotations

import io
from collections.abc import Mapping, Sequence
from functools import lru_cache

from voz.apps.evaluation.failures import Failure
from voz.apps.evaluation.recognize import Task, prepared
from voz.audio import SAMPLE_RATE
from voz.errors import AudioError

MOST_SOUNDS = 100
"""Sounds on a page; each takes some 50 kB."""

LONGEST_SOUND = 20.0
"""Longest sound of one failure, s."""


def sounds_of_failures(failed: Sequence[Failure], tasks: Sequence[Task]) -> Mapping[Failure, bytes]:
    """Return the first failures as FLAC, with the noise and the room that they were heard in.

    `tasks` has that of each result. What cannot be read is left out.
    """
    import soundfile

    heard: dict[Failure, bytes] = {}
    read = lru_cache(1)(prepared)  # successive failures may be of one long recording
    for failure in failed[:MOST_SOUNDS]:
        try:
            samples, _ = read(tasks[failure.number])
        except AudioError:
            continue
        start, end = failure.stretch or (0.0, len(samples) / SAMPLE_RATE)
        end = min(end, start + LONGEST_SOUND)
        flac = io.BytesIO()
        part = samples[int(start * SAMPLE_RATE) : int(end * SAMPLE_RATE)]
        soundfile.write(flac, part, SAMPLE_RATE, format="FLAC")
        heard[failure] = flac.getvalue()
    return heard
