from __future__ import annotations

import pytest

from voz.recognition.language import Language
from voz.recognition.network.score import PhonemeScorer, scorer_for


@pytest.fixture(scope="module")
def scorer(loaded: Language) -> PhonemeScorer:
    return scorer_for(loaded)
