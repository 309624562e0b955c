"""How well a phrase fits a sound by pocketsphinx."""

from __future__ import annotations

import math

import numpy as np
import pytest
from recordings import spoken

from voz.audio import SAMPLE_RATE
from voz.recognition.keyphrase import LEAST_PROBABILITY, KeyphraseScorer

PHONES = {
    "hey robot": ["HH", "EY", "R", "OW", "B", "AA", "T"],
    "computer": ["K", "AH", "M", "P", "Y", "UW", "T", "ER"],
    "athena": ["AH", "TH", "IY", "N", "AH"],
}


@pytest.fixture(scope="module")
def scorers() -> dict[str, KeyphraseScorer]:
    return {phrase: KeyphraseScorer(phones) for phrase, phones in PHONES.items()}


@pytest.mark.parametrize("text", PHONES)
def test_what_is_said_fits_better_than_what_is_not(
    scorers: dict[str, KeyphraseScorer], text: str
) -> None:
    scores = {phrase: scorer.score(spoken(text)) for phrase, scorer in scorers.items()}
    best = scores.pop(text)
    assert max(scores.values()) + 10 < best <= 0


def test_what_was_heard_before_changes_nothing(scorers: dict[str, KeyphraseScorer]) -> None:
    scorer = scorers["computer"]
    before = scorer.score(spoken("computer"))
    scorer.score(np.full(SAMPLE_RATE, 20_000, np.int16))
    assert scorer.score(spoken("computer")) == before


@pytest.mark.parametrize("seconds", [0.001, 0.01])
def test_what_is_too_short_fits_as_badly_as_can_be(
    scorers: dict[str, KeyphraseScorer], seconds: float
) -> None:
    samples = np.zeros(round(seconds * SAMPLE_RATE), np.int16)
    assert scorers["computer"].score(samples) == math.log(LEAST_PROBABILITY) / 8
