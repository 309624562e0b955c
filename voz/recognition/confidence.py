"""How likely it is that a command was said: pure, evidence in, probability out."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from enum import Enum

from voz.language.acoustics.phone_distances import read_distances
from voz.recognition.confidence_model import Model
from voz.recognition.evidence import Alignment, Evidence, Span, covered, overlap

NO_SPEECH, SURE_SPEECH = 0.5, 0.65
"""Between these the voice detector is not sure: of what the end-pointer takes for speech, 97 of 100
noises are below the first, and 95 of 100 commands by people above the second."""

KNOWN, SOFT_SPEECH = 0.9, 0.2
"""What the network is so sure of needs no more voice than this: `up` and `off` are short and soft.
In 0.27 h of noise nothing is accepted by it.
"""

A_BREATH = 5
"""Frames of other sound after a command that mean nothing."""

HURRIED = 0.3
"""In log durations: a word in less than three quarters of its usual time is said in haste."""

CLEAR = 30.0
"""What stands out of the room by so much is heard as well as in a quiet one, dB."""

DROWNED = 2.0
"""Tens of dB under that, below which nothing changes."""


class Context(Enum):
    """What there is within 0.6 s of a command, and what the odds are divided by for it.

    Of 21 stretches of people's talk that sound like a command, 18 have other speech so near: a
    sentence is going on, and hardly anyone says a command in the middle of one. It is no certainty,
    so a command that sounds right is obeyed all the same. Where it was quiet before and what
    follows is yet unknown, 8 lets no more talk through than waiting does, and 6 does.
    """

    QUIET = 1.0
    UNKNOWN_AFTER = 8.0
    SPEECH = 12.0


def features(
    evidence: Evidence,
    phones_of: Mapping[str, Sequence[str]],
    usual: Mapping[str, float] | None = None,
) -> dict[str, float]:
    """Bring the evidence to a few numbers that mean the same for any list of commands.

    Args:
        evidence: what speaks for the command and against it.
        phones_of: the phones of each word of the dictionary.
        usual: how many frames each phone takes; None for those of English.

    Returns:
        The features by name; likelihood ratios are in nats for each frame of speech.
    """
    command, phones = evidence.command, evidence.phones
    usual = usual or read_distances().frames
    words = _spoken_words(command.spans, phones_of)
    after = sum(max(0, p.end - max(p.start - 1, command.spans[-1].end)) for p in phones.spans)
    return {
        "phones": (command.score - phones.score) / phones.frames,
        "worst word": min(word_ratio(word, phones) for word, _ in words),
        "hurried": max(0.0, -min(_pace(word, said, usual) for word, said in words) - HURRIED),
        "not covered": 1 - covered(command, phones) / phones.frames,
        "sound after": math.log1p(max(0, after - A_BREATH)),
    }


def voices_around(above: float, voices: float) -> float:
    """Tell how much of what speaks against a command is due to voices in the room.

    A loop of phones explains voices, and music, better than the command does that is said into
    them. The clatter of a kitchen and motors it explains worse, so that there a command has to be
    surer: of near-misses in a kitchen 10 dB below them 11 of 60 get through without that, and 7
    with it, for three commands in a hundred.

    Args:
        above: how far the command stands out of the room, dB.
        voices: how much of the time there may be a voice in it, 0 to 1.

    Returns:
        A feature, 0 for a quiet room, above it amid voices and below it amid other sound.
    """
    return (2 * voices - 1) * min(DROWNED, max(0.0, (CLEAR - above) / 10))


def word_ratio(word: Span, phones: Alignment) -> float:
    """A word's log-likelihood ratio to the phones in its frames, nats for each frame."""
    against = sum(overlap(word, span) * span.score / span.frames for span in phones.spans)
    return (word.score - against) / word.frames


def probability(model: Model, values: Mapping[str, float]) -> float:
    """Tell how likely it is that the command was said, if it was speech at all.

    Args:
        model: the weights.
        values: what `features` gave.

    Returns:
        Of so many utterances with such features this share is right.
    """
    return chance(model.intercept + sum(w * values[name] for name, w in model.weights.items()))


def trust_in_speech(voice: float, known: float = 0.0) -> float:
    """Tell how far a sound is to be trusted to be speech.

    The likelihoods cannot tell: the phone loop explains a tap as badly as a command does.

    Args:
        voice: what the voice detector gave for the words, 0 to 1.
        known: the probability of the command by the network; 0 without it.

    Returns:
        A factor for the probability, 0 for no speech to 1.
    """
    if known >= KNOWN and voice >= SOFT_SPEECH:
        return 1.0
    return min(1.0, max(0.0, (voice - NO_SPEECH) / (SURE_SPEECH - NO_SPEECH)))


def discount_for_context(sure: float, around: Context) -> float:
    """Tell how likely a command is, 0 to 1, by what is around it; `sure` is if all is quiet."""
    return with_odds(sure, 1 / around.value)


def with_odds(share: float, factor: float) -> float:
    """Multiply the odds of a probability."""
    more = share * factor
    return more / (more + (1 - share))  # so bracketed, never above 1


def _spoken_words(
    spans: Sequence[Span], phones_of: Mapping[str, Sequence[str]]
) -> list[tuple[Span, Sequence[str]]]:
    """The words of a command with their phones; one of a single phone goes with that before it.

    In `gira a la derecha` and `make me a mocha` the `a` is swallowed by the word before it, so it
    is badly explained and said in haste however well the command is said.
    """
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


def chance(log_odds: float) -> float:
    """Turn log-odds to a probability."""
    return 1 / (1 + math.exp(-min(700.0, max(-700.0, log_odds))))


def _pace(word: Span, phones: Sequence[str], usual: Mapping[str, float]) -> float:
    """How slowly a word is said: the logarithm of its time over what its phones usually take."""
    return math.log(word.frames / sum(usual[phone] for phone in phones))
