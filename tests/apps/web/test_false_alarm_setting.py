"""How many false alarms a page may set while the robot is driven."""

from __future__ import annotations

import math
from contextlib import suppress

import pytest
from hypothesis import given
from hypothesis import strategies as st

from voz.api.recognizer import Recognizer
from voz.apps.web.false_alarm_setting import FalseAlarmSetting
from voz.errors import ConfigError
from voz.language.language_files import LanguageFiles
from voz.recognition.engine import confidence_model
from voz.settings import Recognition


@pytest.fixture(scope="module")
def turned(language: LanguageFiles) -> Recognizer:
    return Recognizer(language, Recognition())


@given(alarms=st.floats() | st.integers())
def test_no_number_beyond_what_is_known_is_set(turned: Recognizer, alarms: float) -> None:
    setting = FalseAlarmSetting(turned, Recognition(), lambda *_, **__: None)
    with suppress(ConfigError):
        setting.set(alarms)
    known = [cost.alarms for cost in confidence_model(turned).costs]
    assert min(known) <= setting.alarms <= max(known)
    needed = turned.threshold_of("go forward")
    assert needed is not None
    assert 0 < needed < 1


@pytest.mark.parametrize("alarms", [math.nan, math.inf, 0, -1])
def test_a_recognizer_takes_no_such_number_from_a_program_either(
    turned: Recognizer, alarms: float
) -> None:
    before = turned.threshold_of("go forward")
    with pytest.raises(ConfigError, match=r"at `Recognition\.false_alarms_per_hour`"):
        turned.set_false_alarm_rate(alarms)
    assert turned.threshold_of("go forward") == before
