"""The probability that a command was said, from the evidence for it."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from enum import Enum

from voz.language.phone_distances import read_distances
from voz.recognition.confidence_model import Model
from voz.recognition.evidence import Alignment, Evidence, Span, covered, overlap

NOISE_VOICE, SPEECH_VOICE = 0.5, 0.65
"""Outputs of the voice detector: 97 of 100 noises are below the first, 95 of 100 commands above the
second.
"""

SURE_PROBABILITY, SOFT_SPEECH_VOICE = 0.9, 0.2
"""A command of this probability needs only this voice: `up` and `off` are short and soft."""

IGNORED_FRAMES_AFTER = 5
"""Frames of other sound after a command that do not count: a breath."""

HURRY_TOLERANCE = 0.3
"""In log durations: a word in three quarters of its usual time is not hurried."""

CLEAR_SNR = 30.0
"""Signal-to-noise ratio above which the room does not count, dB."""

MAX_NOISE = 2.0
"""Tens of dB below `CLEAR_SNR` beyond which nothing changes."""


class Context(Enum):
    """What is within 0.6 s of a command; its odds are divided by the value."""

    QUIET = 1.0
    UNKNOWN_AFTER = 8.0
    SPEECH = 12.0


def features(
    evidence: Evidence,
    phones_of: Mapping[str, Sequence[str]],
    usual: Mapping[str, float] | None = None,
) -> dict[str, float]:
    """Compute features that mean the same for any list of commands.

    Args:
        evidence: for the command and against it.
        phones_of: the phones of each word.
        usual: frames that each phone takes; None for those of English.

    Returns:
        The features by name; likelihood ratios are in nats per frame of speech.
    """
    command, phones = evidence.command, evidence.phones
    usual = usual or read_distances().frames
    words = _spoken_words(command.spans, phones_of)
    after = sum(max(0, p.end - max(p.start - 1, command.spans[-1].end)) for p in phones.spans)
    slowness = min(_pace(word, said, usual) for word, said in words)
    return {
        "phones": (command.score - phones.score) / phones.frames,
        "worst word": min(word_ratio(word, phones) for word, _ in words),
        "hurried": max(0.0, -slowness - HURRY_TOLERANCE),
        "not covered": 1 - covered(command, phones) / phones.frames,
        "sound after": math.log1p(max(0, after - IGNORED_FRAMES_AFTER)),
    }


def voices_around(above: float, voices: float) -> float:
    """The feature for voices in the room, which phones explain better than the command does.

    Args:
        above: signal-to-noise ratio, dB.
        voices: share of the time with voices in the room, 0 to 1.

    Returns:
        0 for a quiet room, above it amid voices and below it amid other noise.
    """
    return (2 * voices - 1) * min(MAX_NOISE, max(0.0, (CLEAR_SNR - above) / 10))


def word_ratio(word: Span, phones: Alignment) -> float:
    """A word's log-likelihood ratio to the phones in its frames, nats per frame."""
    against = sum(overlap(word, span) * span.score / span.frames for span in phones.spans)
    return (word.score - against) / word.frames


def probability(model: Model, values: Mapping[str, float]) -> float:
    """The probability of the command by its features, provided that the sound is speech."""
    return sigmoid(model.intercept + sum(w * values[name] for name, w in model.weights.items()))


def trust_in_speech(voice: float, known: float = 0.0) -> float:
    """A factor from 0 to 1 for how surely a sound is speech, which likelihoods do not show.

    Args:
        voice: output of the voice detector for the words, 0 to 1.
        known: the probability of the command by the network; 0 without it.
    """
    if known >= SURE_PROBABILITY and voice >= SOFT_SPEECH_VOICE:
        return 1.0
    return min(1.0, max(0.0, (voice - NOISE_VOICE) / (SPEECH_VOICE - NOISE_VOICE)))


def discount_for_context(confidence: float, context: Context) -> float:
    """The confidence in a context, from that in a quiet one."""
    return multiply_odds(confidence, 1 / context.value)


def multiply_odds(share: float, factor: float) -> float:
    """Multiply the odds of a probability."""
    more = share * factor
    return more / (more + (1 - share))  # so bracketed, never above 1


def _spoken_words(
    spans: Sequence[Span], phones_of: Mapping[str, Sequence[str]]
) -> list[tuple[Span, Sequence[str]]]:
    """The words of a command with their phones; one of a single phone joins the word before it."""
    words: list[tuple[Span, Sequence[str]]] = []
    for span in spans:
        said = phones_of[span.name]
        if len(said) == 1 and words:
            before, phones = words.pop()
            score = before.score + span.score
            words.append((Span(before.name, before.start, span.end, score), (*phones, *said)))
        else:
            words.append((span, said))
    return words


def sigmoid(log_odds: float) -> float:
    """The probability of log-odds."""
    return 1 / (1 + math.exp(-min(700.0, max(-700.0, log_odds))))


def _pace(word: Span, phones: Sequence[str], usual: Mapping[str, float]) -> float:
    """The logarithm of a word's time over what its phones usually take."""
    return math.log(word.frames / sum(usual[phone] for phone in phones))
