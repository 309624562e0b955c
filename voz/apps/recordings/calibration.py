"""Scores a speaker, and finds how far to trust what is heard of them."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import NamedTuple

from voz.audio import Samples
from voz.events import Utterance
from voz.language.language_files import LanguageFiles
from voz.recognition.engine import RecognitionEngine
from voz.recognition.language import load_language
from voz.recognition.profiles import Profile
from voz.settings import Recognition

MIN_SENTENCES = 5
"""Different sentences that a calibration needs."""

DOUBLINGS = (0, 1, 2)
"""How often the odds may be doubled; each lets twice as much else through."""

MIN_GAIN = 0.05
"""Share of the sentences that each doubling of the odds must gain."""


@dataclass(frozen=True)
class Said:
    """A recording (16 kHz) of one sentence by the speaker, and its file if it has one."""

    text: str
    samples: Samples
    file: Path | None = None


class Score(NamedTuple):
    """How well a speaker is understood; each number counts sentences."""

    sentences: int = 0
    right: int = 0  # understood, accepted or not
    accepted: int = 0  # understood and accepted
    wrong: int = 0  # something else was accepted


@dataclass(frozen=True)
class Calibration:
    """The best profile (empty if nothing helps), and the scores without and with it."""

    profile: Profile
    before: Score
    after: Score


def calibrate(
    said: Sequence[Said],
    language: LanguageFiles,
    settings: Recognition,
    advance: Callable[[], None] = lambda: None,
) -> Calibration:
    """Find the best profile of a speaker.

    Args:
        said: recordings of at least `MIN_SENTENCES` different sentences.
        language: the language files.
        settings: of the recognition.
        advance: called after each of `DOUBLINGS`.

    Raises:
        LanguageError: the language files cannot be used.
    """
    model = load_language(language).spoken.model
    scores = {}
    for doublings in DOUBLINGS:
        tried = Profile(doublings * math.log(2), model)
        scores[doublings] = score(said, RecognitionEngine(language, settings, tried))
        advance()
    price = MIN_GAIN * len(said)
    best = max(scores, key=lambda d: scores[d].accepted - scores[d].wrong - d * price)
    profile = Profile(best * math.log(2), model) if best else Profile()
    return Calibration(profile, scores[0], scores[best])


def sentences_in(samples: Samples, recognizer: RecognitionEngine) -> list[Utterance]:
    """The sentences in a recording, accepted or not."""
    return [u for u in recognizer.utterances([samples], "") if u.text]


def score(said: Iterable[Said], recognizer: RecognitionEngine) -> Score:
    """Score a recognizer by known sentences."""
    total = Score()
    for sentence in said:
        text, heard = sentence.text, sentences_in(sentence.samples, recognizer)
        accepted = [u.text for u in heard if u.accepted]
        right = [u.text for u in heard] == [text]
        wrong = any(other != text for other in accepted)
        total = _sum(total, Score(1, right, right and bool(accepted), wrong))
    return total


def _sum(one: Score, other: Score) -> Score:
    return Score(*(a + b for a, b in zip(one, other, strict=True)))
