"""Why an utterance is refused: made-up evidence for each reason, and what people would hear."""

from __future__ import annotations

import numpy as np
import pytest

from voz.audio import Samples
from voz.recognition.evidence import Alignment, Evidence, Span
from voz.recognition.refusal import ALIKE, why_refused

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
        (evidence(-2.5, -2.5, behind=2 * ALIKE), "not_a_command"),
        (None, "too_short"),
    ],
)
def test_the_reason_follows_from_the_evidence(found: Evidence | None, reason: str) -> None:
    assert why_refused(SPEECH, found, 1.0) == (reason, None)


def test_two_commands_that_fit_as_well_are_both_named() -> None:
    for behind in (0.5 * ALIKE, -0.5 * ALIKE):
        found = evidence(-2.5, -2.5, behind=behind)
        assert why_refused(SPEECH, found, 1.0) == ("unsure_between", ("go go", "turn left"))


def test_what_is_no_speech_or_hardly_heard_is_said_first() -> None:
    assert why_refused(SPEECH, evidence(-1.0, -5.0), 0.0) == ("no_speech", None)
    assert why_refused(SPEECH // 200, evidence(-1.0, -5.0), 0.0) == ("too_quiet", None)
