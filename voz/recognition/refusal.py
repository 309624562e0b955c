"""Why an utterance is refused."""

from __future__ import annotations

from collections.abc import Collection

from voz.audio import SAMPLE_RATE, Samples
from voz.audio.denoise import frame_energies
from voz.audio.levels import quantile
from voz.events import Reason
from voz.recognition.confidence import word_ratio
from voz.recognition.evidence import Evidence
from voz.recognition.hypothesis import Refusal
from voz.recognition.phoneme_scorer import Ranking
from voz.recognition.slot_rivals import Rival

MIN_LEVEL = 40.0
"""Level of a far microphone, dB over one unit of 16 bits: 50 dB below full scale."""

MIN_DURATION = 0.35
"""Duration of the shortest command with the margins of its segment, s."""

TIE_RATIO = 0.3
"""Two commands closer than this fit about as well, nats per frame."""

SAID_RATIO = -2.0
"""A word above this was said, nats per frame; 9 of 10 words of right commands are."""

UNSAID_RATIO = -3.0
"""A word below this was not said, nats per frame; 1 of 20 words of right commands is."""

TIE_SCORE = 3.0
"""Two commands closer than this fit about as well by the network, nats."""

SAID_SCORE, UNSAID_SCORE = 1.0, 0.0
"""Scores per phone, nats, above which a word was said, and below which it was not."""


def unusable_sound(samples: Samples, trust: float) -> Reason | None:
    """Why a sound of 16 kHz cannot be judged, if so; `trust` is how surely it is speech, 0 to 1."""
    loudness = frame_energies(samples)
    if len(loudness) and quantile(loudness, 0.95) < MIN_LEVEL:
        return "too_quiet"
    if len(samples) < MIN_DURATION * SAMPLE_RATE:
        return "too_short"
    return None if trust else "no_speech"


def refusal_by_pocketsphinx(evidence: Evidence) -> Refusal:
    """The reason by the evidence for the best command."""
    ratios = [word_ratio(word, evidence.phones) for word in evidence.command.spans]
    if max(ratios) > SAID_RATIO and min(ratios) < UNSAID_RATIO:
        return "part_of_a_command", None
    rival = max(evidence.rivals, key=evidence.rivals.__getitem__, default="")
    if min(ratios) > UNSAID_RATIO and rival:
        behind = (evidence.command.score - evidence.rivals[rival]) / evidence.phones.frames
        if abs(behind) < TIE_RATIO:
            return "unsure_between", (evidence.text, rival)
    return "not_a_command", None


def refusal_by_rival(text: str, other: Rival) -> Refusal:
    """The reason for a command whose rival came too near."""
    return ("part_of_a_command", None) if other.is_begun else ("unsure_between", (text, other.text))


def refusal_by_network(ranking: Ranking, phones: int, words: Collection[float]) -> Refusal:
    """The reason by the scores of the commands, and of each word of the best, nats per phone."""
    best, other = ranking.matches[ranking.text], ranking.matches.get(ranking.next_best)
    if max(words) > SAID_SCORE and min(words) < UNSAID_SCORE:
        return "part_of_a_command", None
    if other and best.score > SAID_SCORE * phones and best.score - other.score < TIE_SCORE:
        return "unsure_between", (ranking.text, ranking.next_best)
    return "not_a_command", None
