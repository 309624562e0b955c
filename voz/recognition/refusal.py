"""Why an utterance is not obeyed, for whoever shows it to the speaker: pure."""

from __future__ import annotations

import numpy as np

from voz.audio import SAMPLE_RATE, Samples
from voz.audio.denoise import energies
from voz.events import Reason
from voz.recognition.confidence import word_ratio
from voz.recognition.evidence import Evidence

QUIET = 40.0
"""Speech below it, in dB over one unit of 16 bits, is 50 dB under full scale: a far microphone."""

SHORT = 3 * SAMPLE_RATE
"""What is longer and was not compared with any command was too long for it."""

ALIKE = 0.3
"""Two commands this close, in nats for each frame, fit about as well."""

FITS = -2.0
"""A word above it, in nats for each frame, fits; 9 of 10 words of right commands do."""

FITS_NOT = -3.0
"""A word below it was not said; 1 of 20 words of right commands is."""


def why_refused(
    samples: Samples, evidence: Evidence | None, trust: float
) -> tuple[Reason, tuple[str, str] | None]:
    """Tell why an utterance that is not accepted was not understood.

    Args:
        samples: the utterance, 16 kHz.
        evidence: what was found for the command that fits best; None if it is too short or too
            long for any.
        trust: how far it is to be trusted to be speech, 0 to 1.

    Returns:
        The reason, and for `unsure_between` the two commands.
    """
    loudness = energies(samples)
    if len(loudness) and np.percentile(loudness, 95) < QUIET:
        return "too_quiet", None
    if evidence is None:
        return ("too_short" if len(samples) < SHORT else "not_a_command"), None
    if trust == 0:
        return "no_speech", None
    ratios = [word_ratio(word, evidence.phones) for word in evidence.command.spans]
    if max(ratios) > FITS and min(ratios) < FITS_NOT:
        return "part_of_a_command", None
    rival = max(evidence.rivals, key=evidence.rivals.__getitem__, default="")
    if min(ratios) > FITS_NOT and rival:
        behind = (evidence.command.score - evidence.rivals[rival]) / evidence.phones.frames
        if abs(behind) < ALIKE:
            return "unsure_between", (evidence.text, rival)
    return "not_a_command", None
