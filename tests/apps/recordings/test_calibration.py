"""A speaker is scored, and trusted more where that pays."""

from __future__ import annotations

import math

import numpy as np
import pytest
from recordings import Recording

from voz.api.recognizer import Recognizer
from voz.apps.recordings import calibration
from voz.apps.recordings.calibration import (
    DOUBLINGS,
    Said,
    Score,
    calibrate,
    score,
)
from voz.audio import SAMPLE_RATE, Samples
from voz.language.language_files import LanguageFiles
from voz.settings import Recognition

ALONE = Recognition(use_network=False)
"""With the network these voices need no more trust."""


@pytest.fixture(scope="module")
def said(recordings: list[Recording]) -> list[Said]:
    """A speaker at a microphone that takes all below 300 and above 3400 Hz away, and tilts."""
    own = [r for r in recordings if r.kind == "command" and r.voice == "flite_slt"]
    return [Said(r.text, telephone(r.samples())) for r in own]


def telephone(plain: Samples) -> Samples:
    frequency = np.fft.rfftfreq(len(plain), 1 / SAMPLE_RATE)
    gain = (((frequency > 300) & (frequency < 3400)) + 0.01) * np.maximum(frequency, 50)
    filtered = np.fft.irfft(np.fft.rfft(plain.astype(float)) * gain, len(plain))
    return (filtered * 0.1 * np.abs(plain).max() / np.abs(filtered).max()).astype(np.int16)


def silence(seconds: float) -> Samples:
    return np.random.default_rng(0).normal(0, 8, int(seconds * SAMPLE_RATE)).astype(np.int16)


def test_each_sentence_is_counted_once_for_what_was_heard(
    recognizer: Recognizer, recordings: list[Recording]
) -> None:
    clips = {r.text: r.samples() for r in recordings if r.voice == "festival_slt"}
    forward, back = clips["go forward"], clips["go back"]
    assert score([Said("go forward", forward)], recognizer) == Score(1, 1, 1, 0)
    assert score([Said("go forward", back)], recognizer) == Score(1, 0, 0, 1)
    assert score([Said("go forward", silence(2))], recognizer) == Score(1, 0, 0, 0)
    both = np.concatenate([forward, silence(1), back])
    assert score([Said("go forward", both)], recognizer) == Score(1, 0, 0, 1)


def test_scores_of_several_sentences_are_added(
    recognizer: Recognizer, recordings: list[Recording]
) -> None:
    clips = {r.text: r.samples() for r in recordings if r.voice == "festival_slt"}
    some = [Said("go forward", clips["go forward"]), Said("stop", clips["go back"])]
    one, other = (score([sentence], recognizer) for sentence in some)
    assert score(some, recognizer) == tuple(a + b for a, b in zip(one, other, strict=True))


@pytest.mark.parametrize(
    ("accepted", "wrong", "doublings"),
    [
        ((20, 20, 20), (0, 0, 0), 0),
        ((10, 11, 12), (0, 0, 0), 0),  # one of 20 is what a doubling costs
        ((10, 12, 12), (0, 0, 0), 1),
        ((10, 12, 14), (0, 0, 0), 2),
        ((10, 12, 14), (0, 0, 3), 1),
        ((10, 12, 14), (0, 2, 4), 0),
    ],
)
def test_a_speaker_is_trusted_more_only_if_each_doubling_of_the_odds_pays(
    accepted: tuple[int, ...],
    wrong: tuple[int, ...],
    doublings: int,
    language: LanguageFiles,
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    scores = [Score(20, 20, *each) for each in zip(accepted, wrong, strict=True)]
    following = iter(scores)
    monkeypatch.setattr(calibration, "score", lambda *_: next(following))
    found = calibrate([Said("stop", silence(1))] * 20, language, ALONE)
    assert found.profile.log_odds == pytest.approx(doublings * math.log(2))
    assert found.profile.model == ("" if doublings else None)
    assert (found.before, found.after) == (scores[0], scores[doublings])


@pytest.mark.slow
def test_a_profile_is_worth_what_it_is_said_to_be(
    said: list[Said], language: LanguageFiles
) -> None:
    steps: list[None] = []
    found = calibrate(said[:6], language, ALONE, lambda: steps.append(None))
    assert len(steps) == len(DOUBLINGS)
    assert found.before == score(said[:6], Recognizer(language, ALONE))
    assert found.after == score(said[:6], Recognizer(language, ALONE, found.profile))
