"""Which symbols of the network stand for a phone."""

from __future__ import annotations

import math

import numpy as np
import pytest

from voz.audio import SAMPLE_RATE
from voz.language.phones import read_distances
from voz.recognition.network.phoneme_network import UnknownNetworkError
from voz.recognition.network.score import MIN_REWARD, PhonemeScorer
from voz.recognition.network.symbols import LAX_SHARE


def test_every_phone_of_the_acoustic_model_has_its_sounds() -> None:
    PhonemeScorer({"all": [sorted(read_distances().frames)]})


def test_quick_speech_leaves_weak_phones_out_and_no_others() -> None:
    """In silence, where no phone is heard, the blank stands for some."""
    silence = np.zeros(SAMPLE_RATE // 2, np.int16)
    phones = ("ɣ", "ʁ", "ɡ", "s")  # noqa: RUF001
    scorer = PhonemeScorer({phone: [[phone]] for phone in phones})
    matches = scorer.rank(scorer.phone_likelihoods(silence), phones).matches
    weak, others = ({matches[phone].score for phone in some} for some in (phones[:2], phones[2:]))
    assert min(weak) > math.log(LAX_SHARE) + MIN_REWARD - 0.1
    assert max(others) < min(weak) - 3


def test_it_knows_no_phones_of_other_languages() -> None:
    with pytest.raises(UnknownNetworkError, match="no phone rr"):
        PhonemeScorer({"rojo": [["R", "rr", "R"]]})
