"""The confidence by hand, its models and their file, and what a rate of alarms costs."""

from __future__ import annotations

import math
from pathlib import Path

import pytest
from hypothesis import given
from hypothesis import strategies as st
from msgspec.structs import replace

from voz.errors import ConfigError
from voz.language.phones import read_distances
from voz.recognition.confidence import (
    NOISE_VOICE,
    OTHER_LANGUAGE_RIVAL_LEAD,
    OTHER_RIVAL_LEAD,
    POCKETSPHINX_FEATURES,
    RIVAL_LEAD,
    SCORE,
    SOFT_SPEECH_VOICE,
    SPEECH_VOICE,
    SURE_PROBABILITY,
    USUAL_GAP,
    VOICES_AROUND,
    WELL_KNOWN,
    Context,
    MissRate,
    Model,
    alarm_rates_near,
    discount_for_context,
    discount_for_gap,
    load_models,
    miss_rate_at,
    multiply_odds,
    own_word_probability,
    probability,
    save_models,
    speech_probability,
    with_log_odds,
)
from voz.recognition.language import Language
from voz.recognition.pocketsphinx.evidence import (
    HURRY_TOLERANCE,
    IGNORED_FRAMES_AFTER,
    Alignment,
    Evidence,
    Span,
    features,
    voices_around,
)

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
    assert [speech_probability(voice) for voice in (0, NOISE_VOICE, SPEECH_VOICE, 1)] == [
        0,
        0,
        1,
        1,
    ]
    assert 0 < speech_probability((NOISE_VOICE + SPEECH_VOICE) / 2) < 1


def test_what_the_network_knows_needs_little_voice_and_some() -> None:
    assert speech_probability(SOFT_SPEECH_VOICE, SURE_PROBABILITY) == 1
    assert speech_probability(SOFT_SPEECH_VOICE - 0.01, 1.0) == 0
    assert speech_probability(SOFT_SPEECH_VOICE, SURE_PROBABILITY - 0.01) == 0


MADE_UP = Model(
    fitted_on=[], intercept=1.0, weights={"phones": 2.0}, alarms=2.0, alarm_exponent=0.5
)


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
    assert load_models().without_network.weights[VOICES_AROUND] > 0


def test_the_models_of_the_package_trust_a_better_match_more() -> None:
    models = load_models()
    assert models.without_network.fitted_on
    assert models.with_network.fitted_on
    assert set(models.without_network.weights) == {*features(SAID, PHONES_OF), VOICES_AROUND}
    assert set(models.without_network.weights) == {*POCKETSPHINX_FEATURES, VOICES_AROUND}
    assert set(models.with_network.weights) == {SCORE}
    for name in ("phones", "worst word"):
        assert models.without_network.weights[name] > 0
    for name in ("hurried", "not covered"):
        assert models.without_network.weights[name] < 0
    assert models.with_network.weights[SCORE] > 0


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


def test_what_was_written_is_read(tmp_path: Path) -> None:
    models = load_models()
    changed = replace(models, without_network=with_log_odds(models.without_network, 1.5))
    save_models(changed, tmp_path / "mine.json")
    assert load_models(str(tmp_path / "mine.json")) == changed
    assert changed.without_network.intercept == models.without_network.intercept + 1.5


def test_a_feature_of_another_voz_is_refused(tmp_path: Path) -> None:
    models = load_models()
    strange = replace(models.with_network, weights={**models.with_network.weights, "luck": 1.0})
    save_models(replace(models, with_network=strange), tmp_path / "mine.json")
    with pytest.raises(ConfigError, match=r'"luck" is no feature of this voz\); name what'):
        load_models(str(tmp_path / "mine.json"))


def test_a_model_fitted_before_there_was_one_score_is_refused(tmp_path: Path) -> None:
    models = load_models()
    older = replace(models.with_network, weights={"worst word": 0.7, "second fit": 1.8})
    save_models(replace(models, with_network=older), tmp_path / "mine.json")
    with pytest.raises(ConfigError, match=r'"second fit" is no feature of this voz'):
        load_models(str(tmp_path / "mine.json"))


@pytest.mark.parametrize("text", ["", "{}", '{"without_network": 3}', "[1,2]", "\x00"])
def test_what_is_no_such_file_is_one_line(text: str, tmp_path: Path) -> None:
    (tmp_path / "mine.json").write_text(text)
    with pytest.raises(ConfigError, match="name what `voz fit-confidence` wrote"):
        load_models(str(tmp_path / "mine.json"))


def test_a_model_that_cannot_be_written_is_one_clear_line(tmp_path: Path) -> None:
    with pytest.raises(ConfigError, match="cannot be written"):
        save_models(load_models(), tmp_path / "none" / "model.json")


COSTS = (MissRate(0.1, 0.3), MissRate(1.0, 0.2), MissRate(10.0, 0.0))


@pytest.mark.parametrize(
    ("alarms", "missed"), [(0.1, 0.3), (10.0, 0.0), (10**-0.5, 0.25), (10**0.5, 0.1)]
)
def test_between_two_rates_the_logarithm_counts(alarms: float, missed: float) -> None:
    assert miss_rate_at(COSTS, alarms) == pytest.approx(missed)


@given(st.floats(0.1, 10), st.floats(0.1, 10))
def test_more_false_alarms_miss_fewer_commands(one: float, other: float) -> None:
    fewer, more = miss_rate_at(COSTS, min(one, other)), miss_rate_at(COSTS, max(one, other))
    assert fewer is not None
    assert more is not None
    assert fewer >= more - 1e-12


@pytest.mark.parametrize("alarms", [0.09, 10.1])
def test_beyond_what_was_looked_at_nothing_is_known(alarms: float) -> None:
    assert miss_rate_at(COSTS, alarms) is None
    assert miss_rate_at((), alarms) is None


@pytest.mark.parametrize("model", [load_models().with_network, load_models().without_network])
def test_what_comes_with_voz_tells_what_it_costs(model: Model) -> None:
    assert tuple(cost.alarms for cost in model.costs) == alarm_rates_near(model.default_alarm_rate)
    missed = [cost.missed for cost in model.costs]
    assert missed == sorted(missed, reverse=True)
    assert missed[0] > missed[-1]


@pytest.mark.parametrize(
    ("text", "limit"), [("go back", RIVAL_LEAD), ("go home", OTHER_RIVAL_LEAD)]
)
def test_the_further_a_rival_word_is_ahead_the_less_was_the_command_said(
    text: str, limit: float
) -> None:
    leads = [-math.inf, -20.0, 0.0, 1.5, limit, 4.8, math.inf]
    likely = [own_word_probability(text, lead) for lead in leads]
    assert likely == sorted(likely, reverse=True)
    assert likely[0] == own_word_probability(text, None) == 1
    assert likely[leads.index(limit)] == 0.5
    assert likely[-1] < 1e-300


def test_in_another_language_a_rival_word_must_be_further_ahead() -> None:
    limit = OTHER_LANGUAGE_RIVAL_LEAD
    assert own_word_probability("para", limit, is_english=False) == 0.5
    assert own_word_probability("go back", limit, is_english=False) == 0.5
    assert own_word_probability("para", None, is_english=False) == 1


@given(st.floats(0, 1), st.floats(0, 3), st.floats(0, 3))
def test_the_longer_a_gap_within_a_word_the_less_was_the_command_said(
    confidence: float, gap: float, longer: float
) -> None:
    assert discount_for_gap(confidence, USUAL_GAP) == confidence
    kept = discount_for_gap(confidence, gap)
    assert 0 <= discount_for_gap(confidence, gap + longer) <= kept + 1e-12 <= confidence + 2e-12


@pytest.mark.parametrize(("gap", "kept"), [(0.28, 0.95), (0.33, 0.88), (0.4, 0.64), (0.6, 0.03)])
def test_however_surely_it_fits_a_command_with_a_long_gap_is_in_doubt(
    gap: float, kept: float
) -> None:
    assert discount_for_gap(1.0, gap) == pytest.approx(kept, abs=0.01)


def test_the_words_of_the_list_that_comes_with_voz_are_well_known(loaded: Language) -> None:
    assert {*loaded.commands.vocabulary} == WELL_KNOWN
