"""A decision is made once and carried; why an utterance is refused, and what rivals it."""

from __future__ import annotations

import math
from collections.abc import Mapping

import numpy as np
import pytest
import soundfile
import soxr
from hypothesis import given
from hypothesis import strategies as st
from language.template_texts import commands_of

from voz.api.recognizer import Recognizer
from voz.audio import SAMPLE_RATE, Samples
from voz.audio.segment import NO_SAMPLES, Segment
from voz.language.build import build
from voz.language.language_files import LanguageFiles
from voz.language.sentences.command_set import Parse, plain_commands
from voz.recognition.confidence import Context, load_models
from voz.recognition.decision import (
    MIN_DURATION,
    RIVAL_SCALE,
    TIE_RATIO,
    TIE_SCORE,
    WORD_ABSENT_SCORE,
    WORD_PRESENT_SCORE,
    Begun,
    DecisionRule,
    Hypothesis,
    Rival,
    find_rival,
    highest_confidence,
    is_too_close,
    refusal_by_network,
    refusal_by_pocketsphinx,
    unusable_sound,
)
from voz.recognition.network.score import Match, Ranking
from voz.recognition.pocketsphinx.evidence import Alignment, Evidence, Span
from voz.recognition.thresholds import MIN_MEANING_SHARE, thresholds_of
from voz.settings import Recognition
from voz.speech.synthesis import cached_speech


@pytest.fixture
def rule() -> DecisionRule:
    model = load_models().with_network
    return DecisionRule(plain_commands(["stop", "go back"]), model, Recognition(threshold=0.5))


def heard(text: str, probability: float) -> Hypothesis:
    return Hypothesis(Segment(0.0, 1.0, 1.2, NO_SAMPLES), text, 1.0, probability=probability)


def test_a_decision_goes_by_the_threshold_that_held_when_it_was_made(rule: DecisionRule) -> None:
    decision = rule.decide(heard("go back", 0.8), Context.QUIET)
    assert (decision.accepted, decision.waits) == (True, True)
    rule.set_false_alarm_rate(Recognition(threshold=0.01))
    amid_speech = decision.within(Context.SPEECH)
    assert (amid_speech.accepted, amid_speech.waits) == (False, False)
    assert amid_speech.required == decision.required
    assert rule.decide(heard("go back", 0.8), Context.SPEECH).accepted  # by the threshold of now


def test_where_nothing_more_is_known_the_decision_is_the_same_one(rule: DecisionRule) -> None:
    for context in Context:
        decision = rule.decide(heard("stop", 0.9), context)
        assert decision.within(context) is decision
        assert decision.within(Context.SPEECH).within(context) == decision


def test_an_answer_is_accepted_as_long_as_it_was_waited_for_when_it_was_said(
    rule: DecisionRule,
) -> None:
    assert rule.decide(heard("yes", 1.0), Context.QUIET).required.threshold is None
    rule.answers = ("yes",)
    decision = rule.decide(heard("yes", 0.9), Context.QUIET)
    assert (decision.accepted, decision.waits) == (True, False)
    rule.answers = ()
    assert decision.within(Context.SPEECH).accepted


def test_any_sentence_of_a_template_that_must_not_be_missed_needs_less() -> None:
    commands = commands_of("stop: halt now | (stop {n: 1..99} {m: 1..99})\ngo back")
    rule = DecisionRule(commands, load_models().with_network, Recognition(missed_cost=4))
    needed = {text: rule.threshold(text) for text in ("halt now", "stop one two", "go back", "no")}
    assert needed["halt now"] == needed["stop one two"] < needed["go back"]
    between = (needed["halt now"] + needed["go back"]) / 2
    assert {text for text in needed if rule.accepts(text, between)} == {"halt now", "stop one two"}
    assert needed["no"] is None
    assert not rule.accepts("no", 1.0)


SPEECH: Samples = np.random.default_rng(0).normal(0, 2000, 16000).astype(np.int16)


def evidence(*word_scores: float, behind: float = 5.0) -> Evidence:
    """Words of 20 frames with so many nats for each, over phones at 0; rivals behind by so much."""
    words = [Span("go", 20 * i, 20 * i + 19, 20 * s) for i, s in enumerate(word_scores)]
    phones = [Span("_AA", w.start, w.end, 0.0) for w in words]
    score = sum(w.score for w in words)
    rivals = {"turn left": score - behind * 20 * len(words), "stop": score - 1e4}
    path = Alignment(score, tuple(words))
    return Evidence("go go", path, rivals, Alignment(0.0, tuple(phones)))


@pytest.mark.parametrize(
    ("found", "reason"),
    [
        (evidence(-4.0, -5.0), "not_a_command"),
        (evidence(-1.0, -5.0), "part_of_a_command"),
        (evidence(-2.5, -2.5, behind=2 * TIE_RATIO), "not_a_command"),
    ],
)
def test_the_reason_follows_from_the_evidence(found: Evidence, reason: str) -> None:
    assert refusal_by_pocketsphinx(found) == (reason, None)


def test_two_commands_that_fit_as_well_are_both_named() -> None:
    for behind in (0.5 * TIE_RATIO, -0.5 * TIE_RATIO):
        found = evidence(-2.5, -2.5, behind=behind)
        assert refusal_by_pocketsphinx(found) == ("unsure_between", ("go go", "turn left"))


PHONES = 8


def scores(best: float, behind: float = 1e3) -> Ranking:
    """So many nats for each phone of the best command, and the next one behind by so many."""
    score = best * PHONES
    scores = {"stop": score - 1e4, "turn left": score - behind, "turn right": score}
    return Ranking({text: Match(score, 0.0, 1.0) for text, score in scores.items()})


WELL, BADLY = WORD_PRESENT_SCORE + 0.5, WORD_ABSENT_SCORE - 0.5


@pytest.mark.parametrize(
    ("heard", "words", "reason"),
    [
        (scores(BADLY), (BADLY, BADLY), "not_a_command"),
        (scores(BADLY), (WELL, BADLY), "part_of_a_command"),
        (scores(BADLY, behind=TIE_SCORE / 2), (WELL, BADLY), "part_of_a_command"),
        (scores(WELL), (WELL, WELL), "not_a_command"),
        (scores(WELL, behind=2 * TIE_SCORE), (WELL, WELL), "not_a_command"),
        (scores(BADLY, behind=TIE_SCORE / 2), (BADLY, BADLY), "not_a_command"),
    ],
)
def test_the_reason_follows_from_what_the_network_makes_of_the_words(
    heard: Ranking, words: tuple[float, ...], reason: str
) -> None:
    assert refusal_by_network(heard, PHONES, words) == (reason, None)


def test_two_commands_that_the_network_hears_as_well_are_both_named() -> None:
    between = ("unsure_between", ("turn right", "turn left"))
    assert refusal_by_network(scores(WELL, behind=TIE_SCORE / 2), PHONES, (WELL, WELL)) == between


def test_a_list_of_one_command_leaves_nothing_to_be_unsure_between() -> None:
    alone = Ranking({"stop": Match(WELL * 4, 0.0, 1.0)})
    assert refusal_by_network(alone, 4, (WELL,)) == ("not_a_command", None)


def test_what_is_no_speech_or_hardly_heard_is_said_first() -> None:
    assert unusable_sound(SPEECH, 0.0) == "no_speech"
    assert unusable_sound(SPEECH // 200, 0.0) == "too_quiet"
    assert unusable_sound(SPEECH[: int(MIN_DURATION * SAMPLE_RATE) - 1], 0.0) == "too_short"
    assert unusable_sound(SPEECH, 0.1) is None


MODEL = load_models().with_network

MEANT = {
    "bring a cup": Parse("bring a cup", "bring", {"thing": "cup"}),
    "bring the cup": Parse("bring the cup", "bring", {"thing": "cup"}),
    "bring a cap": Parse("bring a cap", "bring", {"thing": "cap"}),
    "bring a map": Parse("bring a map", "bring", {"thing": "map"}),
    "go back": Parse("go back", "go back"),
}


def ranked(scores: Mapping[str, float]) -> Ranking:
    return Ranking({text: Match(score, 0.0, 1.0) for text, score in scores.items()})


def test_another_value_that_fits_as_well_takes_half_of_it() -> None:
    found = find_rival(ranked({"bring a cup": 9.0, "bring a cap": 9.0}), MEANT.get)
    assert found
    assert (found.text, found.share) == ("bring a cap", pytest.approx(0.5))
    alike = dict.fromkeys(("bring a cup", "bring a cap", "bring a map"), 9.0)
    both = find_rival(ranked(alike), MEANT.get)
    assert both
    assert both.share == pytest.approx(1 / 3)
    assert is_too_close(both)
    assert 1 / 3 < highest_confidence(both) < thresholds_of(MODEL, Recognition()).usual


def test_the_further_it_is_ahead_the_more_is_left_of_it() -> None:
    ahead = [0.0, 1.0, RIVAL_SCALE, 3 * RIVAL_SCALE, math.inf]
    found = [
        find_rival(ranked({"bring a cup": 20.0, "bring a cap": 20 - a}), MEANT.get) for a in ahead
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
    assert asks(0.5) == asks(0.4) == (False, True)
    assert asks(0.2) == (False, False)
    rule.set_false_alarm_rate(Recognition(threshold=0.1))
    assert not asks(0.5)[0]  # however little a command needs
    rule.set_false_alarm_rate(Recognition(threshold=0.9))
    assert (asks(0.8)[0], asks(0.85)[0]) == (False, True)


def test_a_sentence_of_which_only_the_beginning_was_heard_is_a_rival_too() -> None:
    ranking = ranked({"bring a cup": 9.0, "bring a cap": 0.0})
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
    found = find_rival(ranked(scores), MEANT.get)
    if found:
        assert 0 < found.share <= 1
        again = find_rival(
            ranked({text: score + more for text, score in scores.items()}), MEANT.get
        )
        assert again
        assert again.share == pytest.approx(found.share, abs=1e-6)


def test_other_words_for_the_same_are_no_rival() -> None:
    same = ranked({"bring a cup": 9.0, "bring the cup": 9.0})
    assert find_rival(same, MEANT.get) is None
    other = find_rival(
        ranked({"bring a cup": 9.0, "bring the cup": 9.0, "go back": -90.0}), MEANT.get
    )
    assert other
    assert other.text == "go back"
    assert other.share > 0.99


def test_without_slots_there_is_none() -> None:
    assert find_rival(ranked({"go back": 9.0, "bring a cup": 9.0}), MEANT.get) is None
    assert find_rival(ranked({"go away": 9.0, "bring a cup": 9.0}), MEANT.get) is None
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


def said(text: str, noise: float) -> Samples:
    """A sentence in white noise, whose level beside the sentence's is in dB."""
    sound, rate = soundfile.read(cached_speech(text, "cmu_us_slt_arctic_hts"))
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
    begun: str, servos: Recognizer
) -> None:
    """The beginning sounds most like `center servo one`, and like none of the whole orders."""
    for noise in (-20, -5):
        heard = servos.decode(said(begun, noise), SAMPLE_RATE)[-1]
        assert not heard.accepted
        assert heard.reason == "part_of_a_command"
    whole = begun.replace("set", "center")
    heard = servos.decode(said(whole, -20), SAMPLE_RATE)[-1]
    assert (heard.text, heard.accepted) == (whole, True)


@pytest.mark.slow
@pytest.mark.parametrize(
    ("angle", "some", "much"), [("fifteen", -8, (-6, -3)), ("eighty", -6, (-3, -1))]
)
def test_where_noise_covers_what_tells_two_apart_neither_is_obeyed(
    angle: str, some: float, much: tuple[float, ...], turning: Recognizer
) -> None:
    text = f"turn left {angle} degrees"
    clear = turning.decode(said(text, -40), SAMPLE_RATE)[-1]
    assert (clear.text, clear.accepted) == (text, True)
    noisy = turning.decode(said(text, some), SAMPLE_RATE)[-1]
    assert (noisy.text, noisy.accepted) == (text, True)
    assert noisy.confidence < min(0.98, clear.confidence)  # as the other is near
    for noise in much:
        heard = turning.decode(said(text, noise), SAMPLE_RATE)[-1]
        assert not heard.accepted
        assert heard.reason == "unsure_between"
        assert heard.between
        assert heard.between[0] == heard.text != heard.between[1]
        assert heard.confidence < 0.8
        assert {each.text for each in heard.perhaps} == {*heard.between}
