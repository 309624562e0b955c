"""The numbers that the evidence comes to, computed by hand, and the model of the package."""

from __future__ import annotations

import math

import pytest
from hypothesis import given
from hypothesis import strategies as st

from voz.language.phone_distances import read_distances
from voz.recognition.confidence import (
    HURRY_TOLERANCE,
    IGNORED_FRAMES_AFTER,
    NOISE_VOICE,
    SOFT_SPEECH_VOICE,
    SPEECH_VOICE,
    SURE_PROBABILITY,
    Context,
    discount_for_context,
    features,
    multiply_odds,
    probability,
    trust_in_speech,
    voices_around,
)
from voz.recognition.confidence_model import (
    POCKETSPHINX_FEATURES,
    SCORE,
    VOICES_AROUND,
    Model,
    load_models,
)
from voz.recognition.evidence import Alignment, Evidence, Span

PHONES_OF = {"go": ("G", "OW"), "back(2)": ("B", "AE", "K")}
SAID = Evidence(
    "go back",
    Alignment(-30.0, (Span("go", 10, 19, -8.0), Span("back(2)", 20, 49, -20.0))),
    {"go forward": -70.0, "stop": -90.0},
    Alignment(
        -25.0, (Span("_G", 10, 14, -5.0), Span("_B", 15, 44, -15.0), Span("_K", 50, 59, -4.0))
    ),
)


def test_a_word_of_one_phone_goes_with_the_word_before_it() -> None:
    phones_of = {"turn": ("T", "ER", "N"), "a": ("AH",), "round": ("R", "AW", "N", "D")}
    words = (Span("turn", 0, 29, -3.0), Span("a", 30, 32, -30.0), Span("round", 33, 72, -8.0))
    loop = Alignment(-7.3, (Span("_AA", 0, 72, -7.3),))
    said = Evidence("turn a round", Alignment(-41.0, words), {}, loop)
    found = features(said, phones_of)
    assert found["worst word"] == pytest.approx(-33 / 33 + 0.1)
    assert found["hurried"] == 0  # by itself the a is said in a third of its time
    first = Evidence("a", Alignment(-3.0, (Span("a", 0, 9, -3.0),)), {}, loop)
    assert features(first, phones_of)["worst word"] == pytest.approx(-0.3 + 0.1)


def test_the_features_are_what_they_say() -> None:
    usual = read_distances().frames
    pace = math.log(10 / (usual["G"] + usual["OW"]))
    assert features(SAID, PHONES_OF) == pytest.approx(
        {
            "phones": (-30 + 25) / 45,
            # go: -8 against 5 frames of _G at -1 and 5 of _B at -0.5; back: 25 frames of _B
            "worst word": min((-8 + 7.5) / 10, (-20 + 12.5) / 30),
            "hurried": -pace - HURRY_TOLERANCE,
            "not covered": 10 / 45,
            "sound after": math.log1p(10 - IGNORED_FRAMES_AFTER),
        }
    )


def test_what_is_surely_no_speech_is_not_trusted_at_all() -> None:
    assert [trust_in_speech(voice) for voice in (0, NOISE_VOICE, SPEECH_VOICE, 1)] == [0, 0, 1, 1]
    assert 0 < trust_in_speech((NOISE_VOICE + SPEECH_VOICE) / 2) < 1


def test_what_the_network_knows_needs_little_voice_and_some() -> None:
    assert trust_in_speech(SOFT_SPEECH_VOICE, SURE_PROBABILITY) == 1
    assert trust_in_speech(SOFT_SPEECH_VOICE - 0.01, 1.0) == 0
    assert trust_in_speech(SOFT_SPEECH_VOICE, SURE_PROBABILITY - 0.01) == 0


MADE_UP = Model(fitted_on=[], intercept=1.0, weights={"phones": 2.0}, alarms=2.0, alarms_fall=0.5)


@given(st.floats(-1e3, 1e3), st.floats(-1e3, 1e3))
def test_a_probability_is_between_0_and_1_and_follows_its_features(one: float, two: float) -> None:
    model = MADE_UP
    low, high = (probability(model, {"phones": value}) for value in sorted([one, two]))
    assert 0 <= low <= high <= 1


def test_voices_that_nearly_drown_a_command_speak_for_it_and_other_sound_against_it() -> None:
    assert voices_around(10, 0) < voices_around(20, 0) < 0
    assert voices_around(math.inf, 1) == 0
    assert voices_around(30, 1) == 0
    assert 0 < voices_around(20, 1) < voices_around(15, 1)
    assert voices_around(20, 0.5) < voices_around(20, 1)
    assert voices_around(5, 1) == voices_around(-5, 1)
    assert load_models().one_ear.weights[VOICES_AROUND] > 0


def test_the_models_of_the_package_trust_a_better_match_more() -> None:
    models = load_models()
    assert models.one_ear.fitted_on
    assert models.two_ears.fitted_on
    assert set(models.one_ear.weights) == {*features(SAID, PHONES_OF), VOICES_AROUND}
    assert set(models.one_ear.weights) == {*POCKETSPHINX_FEATURES, VOICES_AROUND}
    assert set(models.two_ears.weights) == {SCORE}
    for name in ("phones", "worst word"):
        assert models.one_ear.weights[name] > 0
    for name in ("hurried", "not covered"):
        assert models.one_ear.weights[name] < 0
    assert models.two_ears.weights[SCORE] > 0


@given(st.floats(0, 1), st.floats(0.01, 100))
def test_odds_keep_a_probability_between_0_and_1(share: float, factor: float) -> None:
    changed = multiply_odds(share, factor)
    assert 0 <= changed <= 1
    assert (changed >= share) == (factor >= 1) or changed == pytest.approx(share)


def test_speech_around_it_makes_a_command_unlikely_but_not_impossible() -> None:
    assert discount_for_context(0.5, Context.SPEECH) < 0.1
    assert discount_for_context(0.99, Context.SPEECH) > 0.85


@given(st.floats(0.01, 0.99))
def test_the_less_is_known_to_be_quiet_the_less_likely_is_a_command(sure: float) -> None:
    around = [
        discount_for_context(sure, a)
        for a in (Context.SPEECH, Context.UNKNOWN_AFTER, Context.QUIET)
    ]
    assert around[0] < around[1] < around[2] == pytest.approx(sure)
