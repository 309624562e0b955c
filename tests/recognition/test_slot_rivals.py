"""What may as well have been meant: another value of a slot."""

from __future__ import annotations

import math
from collections.abc import Mapping
from pathlib import Path

import numpy as np
import pytest
import soundfile
import soxr
from hypothesis import given
from hypothesis import strategies as st

from voz.api.recognizer import Recognizer
from voz.audio import SAMPLE_RATE, Samples
from voz.audio.segment import NO_SAMPLES, Segment
from voz.language.build import build
from voz.language.language_files import LanguageFiles
from voz.language.sentences.command_set import Parse, plain_commands
from voz.recognition.confidence import Context, load_models
from voz.recognition.decision import (
    RIVAL_SCALE,
    Begun,
    DecisionRule,
    Hypothesis,
    Rival,
    find_rival,
    highest_confidence,
    is_too_close,
)
from voz.recognition.network.score import Match, Ranking
from voz.recognition.thresholds import MIN_MEANING_SHARE, thresholds_of
from voz.settings import Recognition
from voz.speech.synthesis import render

MODEL = load_models().with_network

MEANT = {
    "bring a cup": Parse("bring a cup", "bring", {"thing": "cup"}),
    "bring the cup": Parse("bring the cup", "bring", {"thing": "cup"}),
    "bring a cap": Parse("bring a cap", "bring", {"thing": "cap"}),
    "bring a map": Parse("bring a map", "bring", {"thing": "map"}),
    "go back": Parse("go back", "go back"),
}


def heard(scores: Mapping[str, float]) -> Ranking:
    return Ranking({text: Match(score, 0.0, 1.0) for text, score in scores.items()})


def test_another_value_that_fits_as_well_takes_half_of_it() -> None:
    found = find_rival(heard({"bring a cup": 9.0, "bring a cap": 9.0}), MEANT.get)
    assert found
    assert (found.text, found.share) == ("bring a cap", pytest.approx(0.5))
    alike = dict.fromkeys(("bring a cup", "bring a cap", "bring a map"), 9.0)
    both = find_rival(heard(alike), MEANT.get)
    assert both
    assert both.share == pytest.approx(1 / 3)
    assert is_too_close(both)
    assert 1 / 3 < highest_confidence(both) < thresholds_of(MODEL, Recognition()).usual


def test_the_further_it_is_ahead_the_more_is_left_of_it() -> None:
    ahead = [0.0, 1.0, RIVAL_SCALE, 3 * RIVAL_SCALE, math.inf]
    found = [
        find_rival(heard({"bring a cup": 20.0, "bring a cap": 20 - a}), MEANT.get) for a in ahead
    ]
    left = [each.share for each in found if each]
    assert left == sorted(left)
    assert left[-2:] == [pytest.approx(1 / (1 + math.exp(-3))), 1]
    assert [is_too_close(each) for each in found] == [share < MIN_MEANING_SHARE for share in left]
    sure = [highest_confidence(each) for each in found]
    assert sure == sorted(set(sure))
    assert sure[0] > 0.5  # of two that fit alike the best one is the right one more often
    assert sure[-2] < 1 == sure[-1]


def test_what_is_too_close_is_what_the_usual_threshold_refuses() -> None:
    usual = thresholds_of(MODEL, Recognition()).usual
    for share in np.linspace(0.01, 0.99, 99):
        other = Rival("bring a cap", float(share))
        assert is_too_close(other) == (highest_confidence(other) < usual)


def test_the_robot_may_ask_where_a_rival_is_near_and_where_it_is_far_ahead_it_may_not() -> None:
    rule = DecisionRule(plain_commands(["bring a cup"]), MODEL, Recognition(ask="always"))
    segment = Segment(0.0, 1.0, 1.0, NO_SAMPLES)

    def asks(share: float) -> tuple[bool, bool]:
        rival = Rival("bring a cap", share)
        said = Hypothesis(segment, "bring a cup", 1.0, probability=1.0, rival=rival)
        decision = rule.decide(said, Context.SPEECH)
        assert decision.confidence == highest_confidence(rival)  # whatever is around it
        assert decision.for_rival != decision.accepted
        return decision.accepted, decision.is_nearly_sure

    assert asks(0.9) == (True, True)
    assert asks(0.5) == asks(0.35) == (False, True)
    assert asks(0.2) == (False, False)
    rule.set_false_alarm_rate(Recognition(threshold=0.1))
    assert not asks(0.5)[0]  # however little a command needs
    rule.set_false_alarm_rate(Recognition(threshold=0.9))
    assert (asks(0.7)[0], asks(0.8)[0]) == (False, True)


def test_a_sentence_of_which_only_the_beginning_was_heard_is_a_rival_too() -> None:
    ranking = heard({"bring a cup": 9.0, "bring a cap": 0.0})
    alone = find_rival(ranking, MEANT.get)
    assert alone
    assert not alone.is_begun
    for ahead, refused in ((-20.0, False), (-3.0, False), (1.0, True), (5_000.0, True)):
        other = find_rival(ranking, MEANT.get, Begun("fling a", 9.0 + ahead))
        assert other
        assert other.share <= alone.share
        assert is_too_close(other) == refused
        assert (other.text == "fling a") == other.is_begun
        assert other.is_begun or not refused
    assert find_rival(ranking, MEANT.get, Begun("", -math.inf)) == alone


@given(
    st.dictionaries(st.sampled_from([*MEANT]), st.integers(-50, 50), min_size=1),
    st.integers(-50, 50),
)
def test_it_is_a_share_and_only_what_is_between_the_scores_counts(
    scores: dict[str, int], more: int
) -> None:
    found = find_rival(heard(scores), MEANT.get)
    if found:
        assert 0 < found.share <= 1
        again = find_rival(heard({text: score + more for text, score in scores.items()}), MEANT.get)
        assert again
        assert again.share == pytest.approx(found.share, abs=1e-6)


def test_other_words_for_the_same_are_no_rival() -> None:
    same = heard({"bring a cup": 9.0, "bring the cup": 9.0})
    assert find_rival(same, MEANT.get) is None
    other = find_rival(
        heard({"bring a cup": 9.0, "bring the cup": 9.0, "go back": -90.0}), MEANT.get
    )
    assert other
    assert other.text == "go back"
    assert other.share > 0.99


def test_without_slots_there_is_none() -> None:
    assert find_rival(heard({"go back": 9.0, "bring a cup": 9.0}), MEANT.get) is None
    assert find_rival(heard({"go away": 9.0, "bring a cup": 9.0}), MEANT.get) is None
    assert not is_too_close(None)
    assert highest_confidence(None) == 1


@pytest.fixture(scope="module")
def turning(tmp_path_factory: pytest.TempPathFactory) -> Recognizer:
    """Knows angles, of which two sound nearly the same."""
    folder = tmp_path_factory.mktemp("turning")
    lines = ["turn left {angle} degrees", "stop", "angle = 5..180 by 5"]
    (folder / "list.txt").write_text("\n".join(lines))
    build(folder / "list.txt", folder)
    return Recognizer(LanguageFiles(folder), Recognition(ask="always"))


def said(text: str, folder: Path, noise: float) -> Samples:
    """A sentence in white noise, whose level beside the sentence's is in dB."""
    render(text, "cmu_us_slt_arctic_hts", folder / "said.wav")
    sound, rate = soundfile.read(folder / "said.wav")
    speech = soxr.resample(sound, rate, SAMPLE_RATE)
    level = np.sqrt((speech**2).mean()) * 10 ** (noise / 20)
    around = np.pad(speech, (2 * SAMPLE_RATE, SAMPLE_RATE))
    mixed = around + np.random.default_rng(0).normal(0, level, len(around))
    return (mixed / np.abs(mixed).max() * 20_000).astype(np.int16)


@pytest.fixture(scope="module")
def servos(tmp_path_factory: pytest.TempPathFactory) -> Recognizer:
    """Knows servos and their angles, and another order, which is short."""
    folder = tmp_path_factory.mktemp("servos")
    lines = ["set servo {number: 1..8} to {angle: 0..180 by 5}", "center servo {number: 1..8}"]
    (folder / "list.txt").write_text("\n".join([*lines, "stop"]))
    build(folder / "list.txt", folder)
    return Recognizer(LanguageFiles(folder), Recognition())


@pytest.mark.slow
@pytest.mark.parametrize("begun", ["set servo one", "set servo seven"])
def test_an_order_of_which_only_the_beginning_is_heard_is_not_obeyed_as_another(
    begun: str, servos: Recognizer, tmp_path: Path
) -> None:
    """The beginning sounds most like `center servo one`, and like none of the whole orders."""
    for noise in (-20, -5):
        heard = servos.decode(said(begun, tmp_path, noise), SAMPLE_RATE)[-1]
        assert not heard.accepted
        assert heard.reason == "part_of_a_command"
    whole = begun.replace("set", "center")
    heard = servos.decode(said(whole, tmp_path, -20), SAMPLE_RATE)[-1]
    assert (heard.text, heard.accepted) == (whole, True)


@pytest.mark.slow
@pytest.mark.parametrize("angle", ["fifteen", "fifty"])
def test_where_noise_covers_what_tells_two_apart_neither_is_obeyed(
    angle: str, turning: Recognizer, tmp_path: Path
) -> None:
    text = f"turn left {angle} degrees"
    clear = turning.decode(said(text, tmp_path, -40), SAMPLE_RATE)[-1]
    assert (clear.text, clear.accepted) == (text, True)
    noisy = turning.decode(said(text, tmp_path, -9), SAMPLE_RATE)[-1]
    assert (noisy.text, noisy.accepted) == (text, True)
    assert noisy.confidence < min(0.97, clear.confidence)  # as the other is near
    for noise in (-6, -3):
        heard = turning.decode(said(text, tmp_path, noise), SAMPLE_RATE)[-1]
        assert not heard.accepted
        assert heard.reason == "unsure_between"
        assert heard.between
        assert heard.between[0] == heard.text != heard.between[1]
        assert heard.confidence < 0.8
        assert {each.text for each in heard.perhaps} == {*heard.between}
