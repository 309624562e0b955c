"""Why an utterance is not obeyed, for whoever shows it to the speaker: pure."""

from __future__ import annotations

from collections.abc import Collection

import numpy as np

from voz.audio import SAMPLE_RATE, Samples
from voz.audio.denoise import frame_energies
from voz.events import Reason
from voz.recognition.confidence import word_ratio
from voz.recognition.evidence import Evidence
from voz.recognition.hypothesis import Refusal
from voz.recognition.phoneme_scorer import Ranking

QUIET = 40.0
"""Speech below it, in dB over one unit of 16 bits, is 50 dB under full scale: a far microphone."""

SHORT = 0.35
"""Seconds with the margins of a segment: no command is said in less."""

ALIKE = 0.3
"""Two commands this close, in nats for each frame, fit about as well."""

FITS = -2.0
"""A word above it, in nats for each frame, fits; 9 of 10 words of right commands do."""

FITS_NOT = -3.0
"""A word below it was not said; 1 of 20 words of right commands is."""

CLOSE = 3.0
"""Two commands this close, in nats of the network, fit about as well."""

SAID, NOT_SAID = 1.0, 0.0
"""By the network: what has so many nats for each phone was said, or was not; 2 are perfect."""


def unusable_sound(samples: Samples, trust: float) -> Reason | None:
    """Tell whether there is too little to hear.

    Args:
        samples: the utterance, 16 kHz.
        trust: how far it is to be trusted to be speech, 0 to 1.
    """
    loudness = frame_energies(samples)
    if len(loudness) and np.percentile(loudness, 95) < QUIET:
        return "too_quiet"
    if len(samples) < SHORT * SAMPLE_RATE:
        return "too_short"
    return None if trust else "no_speech"


def refusal_by_pocketsphinx(evidence: Evidence) -> Refusal:
    """Tell why an utterance is no command, by pocketsphinx.

    Args:
        evidence: what was found for the command that fits best.
    """
    ratios = [word_ratio(word, evidence.phones) for word in evidence.command.spans]
    if max(ratios) > FITS and min(ratios) < FITS_NOT:
        return "part_of_a_command", None
    rival = max(evidence.rivals, key=evidence.rivals.__getitem__, default="")
    if min(ratios) > FITS_NOT and rival:
        behind = (evidence.command.score - evidence.rivals[rival]) / evidence.phones.frames
        if abs(behind) < ALIKE:
            return "unsure_between", (evidence.text, rival)
    return "not_a_command", None


def refusal_by_network(ranking: Ranking, phones: int, words: Collection[float]) -> Refusal:
    """Tell why an utterance is no command, by the network.

    Args:
        ranking: what it makes of the commands.
        phones: of the command that fits best.
        words: how well each word of that fits, nats for each phone.
    """
    best, other = ranking.matches[ranking.text], ranking.matches.get(ranking.next_best)
    if max(words) > SAID and min(words) < NOT_SAID:
        return "part_of_a_command", None
    if other and best.score > SAID * phones and best.score - other.score < CLOSE:
        return "unsure_between", (ranking.text, ranking.next_best)
    return "not_a_command", None
