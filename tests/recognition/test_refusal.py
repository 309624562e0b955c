"""Why an utterance is refused: made-up evidence for each reason, and what people would hear."""

from __future__ import annotations

import numpy as np
import pytest

from voz.audio import SAMPLE_RATE, Samples
from voz.recognition.evidence import Alignment, Evidence, Span
from voz.recognition.phoneme_scorer import Match, Ranking
from voz.recognition.refusal import (
    MIN_DURATION,
    SAID_SCORE,
    TIE_RATIO,
    TIE_SCORE,
    UNSAID_SCORE,
    refusal_by_network,
    refusal_by_pocketsphinx,
    unusable_sound,
)

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


WELL, BADLY = SAID_SCORE + 0.5, UNSAID_SCORE - 0.5


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
