from __future__ import annotations

import pytest

from voz.recognition.language import Language
from voz.recognition.second_ear import SecondEar, second_ear_for


@pytest.fixture(scope="module")
def ear(loaded: Language) -> SecondEar:
    return second_ear_for(loaded)
