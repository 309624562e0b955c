"""A decision is made once and carried; why an utterance is refused, by made-up evidence."""

from __future__ import annotations

import numpy as np
import pytest
from language.template_texts import commands_of

from voz.audio import SAMPLE_RATE, Samples
from voz.audio.segment import NO_SAMPLES, Segment
from voz.language.sentences.command_set import plain_commands
from voz.recognition.confidence import Context, load_models
from voz.recognition.decision import (
    MIN_DURATION,
    TIE_RATIO,
    TIE_SCORE,
    WORD_ABSENT_SCORE,
    WORD_PRESENT_SCORE,
    DecisionRule,
    Hypothesis,
    refusal_by_network,
    refusal_by_pocketsphinx,
    unusable_sound,
)
from voz.recognition.network.score import Match, Ranking
from voz.recognition.pocketsphinx.evidence import Alignment, Evidence, Span
from voz.settings import Recognition


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
