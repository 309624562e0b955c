"""Finds what pays for a speaker: judged on sentences that it was not fitted on."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Sequence
from pathlib import Path
from typing import NamedTuple

from msgspec.structs import replace

from voz.audio import Samples
from voz.audio.denoise import denoise_if_noisy
from voz.audio.endpointing.segmenter import segments
from voz.events import Utterance
from voz.language.generated.language_files import LanguageFiles
from voz.recognition.decoder import mean_start
from voz.recognition.language import load_language
from voz.recognition.recognizer import Recognizer
from voz.recognition.speaker.adaptation import Aligner, StartVector
from voz.recognition.speaker.mllr import as_text, fit_transforms
from voz.recognition.speaker.profiles import Profile
from voz.settings import Recognition

FOLDS = 7
"""Parts that the sentences are dealt out to: each is judged by what the others gave."""

FEWEST = 5
"""Different sentences below which nothing can be said about others."""

DOUBLINGS = (0, 1, 2)
"""How often the odds of a confidence may be doubled: twice, and twice as much else gets through."""

PRICE = 0.05
"""Share of the sentences that each doubling of the odds must gain."""

ALIGNED_AGAIN = 2
"""Times that the start is fitted: from a better start, the phones are found better."""


class Said(NamedTuple):
    """A recording of one sentence by the speaker.

    Attributes:
        text: the sentence.
        samples: the sound, 16 kHz.
        file: where it is, if it is in a file.
    """

    text: str
    samples: Samples
    file: Path | None = None


class Score(NamedTuple):
    """How a speaker is understood.

    Attributes:
        sentences: how many were said.
        right: those that were heard right.
        obeyed: those that were heard right and accepted.
        wrong: those in which something else was accepted.
        confidence: the sum of the confidences of those heard right.
    """

    sentences: int = 0
    right: int = 0
    obeyed: int = 0
    wrong: int = 0
    confidence: float = 0.0

    @property
    def worth(self) -> tuple[float, ...]:
        """Ranks scores: first by what the robot would do, then by how sure it is."""
        return self.obeyed - self.wrong, self.right, self.confidence


class Calibration(NamedTuple):
    """What was found.

    Attributes:
        profile: the best one; an empty one if nothing pays.
        before: how the speaker is understood without it.
        after: how sentences are understood that were not used to make it.
    """

    profile: Profile
    before: Score
    after: Score


WAYS: tuple[Callable[[Profile], Profile], ...] = (
    lambda fitted: Profile(),
    lambda fitted: Profile(fitted.start),
    lambda fitted: fitted,
)
"""What may be kept of what was fitted; of what is equally good, the first."""

STEPS = len(WAYS) + len(DOUBLINGS) - 1
"""How many ways are tried."""


def calibrate(
    said: Sequence[Said],
    language: LanguageFiles,
    settings: Recognition,
    folder: Path,
    advance: Callable[[], None] = lambda: None,
) -> Calibration:
    """Find the profile of a speaker.

    Args:
        said: recordings of sentences of the language, at least `FEWEST` different ones.
        language: the language files.
        settings: how they are recognized.
        folder: an existing one, where the profile finds the file of its transform.
        advance: called after each of `STEPS`.

    Returns:
        The profile, and what it is worth.

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
            total = _sum(total, score(part, Recognizer(language, settings, tried)))
        advance()
        return total

    scores = [judge(way) for way in WAYS]
    best = max(range(len(WAYS)), key=lambda number: scores[number].worth)
    way = WAYS[best]
    trusted = {0: scores[best]} | {d: judge(way, d * math.log(2)) for d in DOUBLINGS[1:]}
    price = PRICE * len(said)
    doublings = max(trusted, key=lambda d: trusted[d].worth[0] - d * price)
    profile = replace(way(final), log_odds=doublings * math.log(2))
    if profile != Profile():
        profile = replace(profile, model=loaded.spoken.model)
    return Calibration(profile, scores[0], trusted[doublings])


def fit(said: Iterable[Said], aligner: Aligner, mllr: Path) -> Profile:
    """Fit all that can be fitted to sentences that are known.

    Args:
        said: the sentences; those in which there are pauses are left out.
        aligner: finds their phones.
        mllr: where to write the transform.

    Returns:
        The profile; an empty one if nothing could be aligned.
    """
    found = [(sentence.text, list(segments([sentence.samples]))) for sentence in said]
    heard = [(text, denoise_if_noisy(alone[0].samples)) for text, alone in found if len(alone) == 1]
    speech = [(text, samples, mean_start(samples)) for text, samples in heard]
    learnt = StartVector()
    for _ in range(ALIGNED_AGAIN):
        seen = [aligner.observe(samples, text, start, learnt) for text, samples, start in speech]
        learnt = StartVector()
        for observation in filter(None, seen):
            learnt = learnt.updated(observation)
    moved = [(text, samples, learnt.moved(start)) for text, samples, start in speech]
    aligned = [(aligner.align(samples, text, start), start) for text, samples, start in moved]
    spoken = [(phones, start) for phones, start in aligned if phones]
    if not spoken:
        return Profile()
    mllr.write_text(as_text(fit_transforms(spoken, aligner.model)), encoding="ascii")
    return Profile(learnt, str(mllr))


def sentences_in(samples: Samples, recognizer: Recognizer) -> list[Utterance]:
    """Recognize all that may be a sentence in a recording, accepted or not."""
    return [u for u in recognizer.utterances([samples], "") if u.text]


def score(said: Iterable[Said], recognizer: Recognizer) -> Score:
    """Count how many sentences are understood."""
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
    """Deal the sentences out; whoever says one twice does not help to judge it."""
    texts = list(dict.fromkeys(sentence.text for sentence in said))
    number = min(FOLDS, len(texts))
    return [[s for s in said if texts.index(s.text) % number == part] for part in range(number)]


def _sum(one: Score, other: Score) -> Score:
    return Score(*(a + b for a, b in zip(one, other, strict=True)))  # type: ignore[arg-type]
