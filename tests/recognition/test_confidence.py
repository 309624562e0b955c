"""The numbers that the evidence comes to, computed by hand, and the model of the package."""

from __future__ import annotations

import math

import pytest
from hypothesis import given
from hypothesis import strategies as st

from voz.recognition.confidence import (
    CLEAR_MARGIN,
    NO_SPEECH,
    SURE_SPEECH,
    Model,
    features,
    load_model,
    probability,
    trust_in_speech,
)
from voz.recognition.evidence import Evidence, Path, Span

PHONES_IN = {"go": 2, "back(2)": 3}
SAID = Evidence(
    "go back",
    Path(-30.0, (Span("go", 10, 19, -8.0), Span("back(2)", 20, 49, -20.0))),
    {"go forward": -70.0, "stop": -90.0},
    Path(-25.0, (Span("_G", 10, 14, -5.0), Span("_B", 15, 44, -15.0), Span("_K", 50, 54, -4.0))),
)


def test_the_features_are_what_they_say() -> None:
    assert features(SAID, PHONES_IN) == pytest.approx(
        {
            "phones": (-30 + 25) / 40,
            # go: -8 against 5 frames of _G at -1 and 5 of _B at -0.5; back: 25 frames of _B
            "worst word": min((-8 + 7.5) / 10, (-20 + 12.5) / 30),
            "rival": (-30 + 70) / 40,
            "not covered": 5 / 40,
            "frames outside": math.log1p(5),
            "quickest word": math.log(5),
            "slowest word": math.log(10),
        }
    )


def test_a_rival_that_is_far_behind_is_like_none() -> None:
    alone = features(SAID._replace(rivals={}), PHONES_IN)
    far = features(SAID._replace(rivals={"stop": -30 - 40 * CLEAR_MARGIN - 1}), PHONES_IN)
    assert alone["rival"] == far["rival"] == CLEAR_MARGIN


def test_what_is_surely_no_speech_is_not_trusted_at_all() -> None:
    assert [trust_in_speech(voice) for voice in (0, NO_SPEECH, SURE_SPEECH, 1)] == [0, 0, 1, 1]
    assert 0 < trust_in_speech((NO_SPEECH + SURE_SPEECH) / 2) < 1


@given(st.floats(-1e3, 1e3), st.floats(-1e3, 1e3))
def test_a_probability_is_between_0_and_1_and_follows_its_features(one: float, two: float) -> None:
    model = Model(fitted_on=[], intercept=1.0, weights={"phones": 2.0})
    low, high = (probability(model, {"phones": value}) for value in sorted([one, two]))
    assert 0 <= low <= high <= 1


def test_the_model_of_the_package_trusts_a_better_match_and_speech_more() -> None:
    model = load_model()
    assert model.fitted_on
    assert set(model.weights) == set(features(SAID, PHONES_IN))
    for name in ("phones", "worst word", "rival", "quickest word"):
        assert model.weights[name] > 0
