"""Fits a profile to a speaker, by cross-validation."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import NamedTuple

from msgspec.structs import replace

from voz.audio import Samples
from voz.audio.denoise import denoise_if_noisy
from voz.audio.segmenter import segments
from voz.events import Utterance
from voz.language.language_files import LanguageFiles
from voz.recognition.engine import RecognitionEngine
from voz.recognition.language import load_language
from voz.recognition.pocketsphinx.decoder import mean_start
from voz.recognition.speaker.adaptation import Aligner, StartVector, as_text, fit_transforms
from voz.recognition.speaker.profiles import Profile
from voz.settings import Recognition

FOLDS = 7
"""Parts of the cross-validation."""

MIN_SENTENCES = 5
"""Different sentences that a calibration needs."""

DOUBLINGS = (0, 1, 2)
"""How often the odds may be doubled; each lets twice as much else through."""

MIN_GAIN = 0.05
"""Share of the sentences that each doubling of the odds must gain."""

ALIGNMENT_ROUNDS = 2
"""How often the start is fitted; a better start gives a better alignment."""


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
    confidence: float = 0.0  # sum of the confidences of those understood

    @property
    def sort_key(self) -> tuple[float, ...]:
        """Sorts scores: by what the robot would do, then by the confidence."""
        return self.accepted - self.wrong, self.right, self.confidence


@dataclass(frozen=True)
class Calibration:
    """The best profile (empty if nothing helps), and the scores without and with it."""

    profile: Profile
    before: Score
    after: Score


PROFILE_PARTS: tuple[Callable[[Profile], Profile], ...] = (
    lambda fitted: Profile(),
    lambda fitted: Profile(fitted.start),
    lambda fitted: fitted,
)
"""Parts of a fitted profile that may be kept; of equal ones the first."""

CALIBRATION_STEPS = len(PROFILE_PARTS) + len(DOUBLINGS) - 1
"""Number of profiles that are scored."""


def calibrate(
    said: Sequence[Said],
    language: LanguageFiles,
    settings: Recognition,
    folder: Path,
    advance: Callable[[], None] = lambda: None,
) -> Calibration:
    """Find the best profile of a speaker.

    Args:
        said: recordings of at least `MIN_SENTENCES` different sentences.
        language: the language files.
        settings: of the recognition.
        folder: an existing one, for the transform.
        advance: called after each of `CALIBRATION_STEPS`.

    Raises:
        LanguageError: the language files cannot be used.
    """
    loaded = load_language(language)
    aligner = Aligner(loaded)
    parts = _parts(said)
    training = [[s for other in parts if other is not part for s in other] for part in parts]
    *fitted, final = (
        fit(sentences, aligner, folder / f"{number}.txt")
        for number, sentences in enumerate([*training, said])
    )

    def judge(way: Callable[[Profile], Profile], log_odds: float = 0.0) -> Score:
        total = Score()
        for part, profile in zip(parts, fitted, strict=True):
            tried = replace(way(profile), log_odds=log_odds)
            total = _sum(total, score(part, RecognitionEngine(language, settings, tried)))
        advance()
        return total

    scores = [judge(way) for way in PROFILE_PARTS]
    best = max(range(len(PROFILE_PARTS)), key=lambda number: scores[number].sort_key)
    way = PROFILE_PARTS[best]
    trusted = {0: scores[best]} | {d: judge(way, d * math.log(2)) for d in DOUBLINGS[1:]}
    price = MIN_GAIN * len(said)
    doublings = max(trusted, key=lambda d: trusted[d].sort_key[0] - d * price)
    profile = replace(way(final), log_odds=doublings * math.log(2))
    if profile != Profile():
        profile = replace(profile, model=loaded.spoken.model)
    return Calibration(profile, scores[0], trusted[doublings])


def fit(said: Iterable[Said], aligner: Aligner, mllr: Path) -> Profile:
    """Fit a whole profile; an empty one if nothing could be aligned.

    Args:
        said: the sentences; those with pauses are left out.
        aligner: finds their phones.
        mllr: where to write the transform.
    """
    found = [(sentence.text, list(segments([sentence.samples]))) for sentence in said]
    heard = [(text, denoise_if_noisy(alone[0].samples)) for text, alone in found if len(alone) == 1]
    speech = [(text, samples, mean_start(samples)) for text, samples in heard]
    learned = StartVector()
    for _ in range(ALIGNMENT_ROUNDS):
        seen = [aligner.observe(samples, text, start, learned) for text, samples, start in speech]
        learned = StartVector()
        for observation in filter(None, seen):
            learned = learned.updated(observation)
    moved = [(text, samples, learned.moved(start)) for text, samples, start in speech]
    aligned = [(aligner.align(samples, text, start), start) for text, samples, start in moved]
    spoken = [(phones, start) for phones, start in aligned if phones]
    if not spoken:
        return Profile()
    mllr.write_text(as_text(fit_transforms(spoken, aligner.model)), encoding="ascii")
    return Profile(learned, str(mllr))


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
        sure = heard[0].confidence if right else 0.0
        total = _sum(total, Score(1, right, right and bool(accepted), wrong, sure))
    return total


def _parts(said: Sequence[Said]) -> list[list[Said]]:
    """Divide the sentences for cross-validation, equal ones together."""
    texts = list(dict.fromkeys(sentence.text for sentence in said))
    number = min(FOLDS, len(texts))
    return [[s for s in said if texts.index(s.text) % number == part] for part in range(number)]


def _sum(one: Score, other: Score) -> Score:
    return Score(*(a + b for a, b in zip(one, other, strict=True)))  # type: ignore[arg-type]
