"""Whether a command was said, or what is one phone away from it."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from recordings import Recording

from voz.language.build import build
from voz.language.language_files import LanguageFiles
from voz.recognition.language import Language, load_language
from voz.recognition.network.ctc import Floats
from voz.recognition.network.rival_words import RivalWords
from voz.recognition.network.score import PhonemeScorer, scorer_for

BLANK = 3


def lead(scorer: PhonemeScorer, clip: Recording, text: str) -> float | None:
    likelihoods = scorer.phone_likelihoods(clip.samples())
    return scorer.rival_lead(likelihoods, text, scorer.rank(likelihoods, [text]).matches[text])


def test_no_word_one_phone_away_fits_much_better_than_what_is_said(
    loaded: Language, scorer: PhonemeScorer, recordings: list[Recording]
) -> None:
    commands = [r for r in recordings if r.kind == "command" and r.text in loaded.commands]
    leads = [lead(scorer, clip, clip.text) for clip in commands]
    assert len(leads) > 50
    assert np.mean([each is not None and each < 1.5 for each in leads]) > 0.95


def test_what_is_one_phone_away_from_what_is_said_is_far_behind(
    tmp_path: Path, recordings: list[Recording]
) -> None:
    """A list has the neighbors of what is said in the recordings."""
    neighbors = {
        "go back": "go bag",
        "turn left": "burn left",
        "turn right": "turn light",
        "fold arm": "cold arm",
        "point beer": "point dear",
        "slow down": "flow down",
    }
    (tmp_path / "list.txt").write_text("\n".join([*neighbors.values(), "stop"]))
    build(tmp_path / "list.txt", tmp_path)
    scorer = scorer_for(load_language(LanguageFiles(tmp_path)))
    said = [r for r in recordings if r.kind == "command" and r.text in neighbors]
    leads = [lead(scorer, clip, neighbors[clip.text]) for clip in said]
    assert len(leads) > 20
    assert np.mean([each is not None and each > 1.5 for each in leads]) > 0.9


def sound(*symbols: int) -> tuple[Floats, Floats, Floats]:
    """A sound of these symbols, a moment each, where any other costs 5 nats."""
    log_ratios = np.full((len(symbols), BLANK + 1), -5.0)
    log_ratios[np.arange(len(symbols)), symbols] = 0
    return log_ratios, np.zeros(len(symbols)), np.zeros(len(symbols))


def test_the_lead_is_what_another_phone_costs() -> None:
    rivals = RivalWords({"x": [[0, 1]], "y": [[2, 0]]}, {"x": [[2, 1]]}, BLANK, reward=2.0)
    assert rivals.lead("x", *sound(0, 1)) == pytest.approx(-5)
    assert rivals.lead("x", *sound(2, 1)) == pytest.approx(5)
    assert rivals.lead("y x", *sound(2, 0, BLANK, 2, 1)) == pytest.approx(5)
    assert rivals.lead("x y", *sound(0, 1, BLANK, 2, 0)) == pytest.approx(-5)


def test_of_a_longer_rival_each_phone_is_worth_as_much_as_of_the_command() -> None:
    rivals = RivalWords({"x": [[0, 1]]}, {"x": [[0, 1, 2]]}, BLANK, reward=2.0)
    assert rivals.lead("x", *sound(0, 1, 2)) == pytest.approx(2)


def test_a_word_without_rivals_has_no_lead() -> None:
    rivals = RivalWords({"x": [[0, 1]], "y": [[2]]}, {"y": [], "x": [[0, 1]]}, BLANK, reward=2.0)
    assert rivals.lead("x y", *sound(0, 1, 2)) is None


def test_long_sentences_and_slurred_words_have_no_rivals() -> None:
    said = {"go": [[0, 1]], "the": [[2, 0]]}
    rivals = RivalWords(said, {"go": [[2, 1]], "the": [[1, 0]]}, BLANK, reward=2.0)
    assert rivals.lead("the the the", *sound(0, 1, 2, 0, 1, 0)) is None
    assert rivals.lead("go the", *sound(2, 1, 2, 0)) == pytest.approx(5)
    assert rivals.lead("go the go go", *sound(0, 1, 2, 0, 0, 1, BLANK, 0, 1)) is None


def test_rivals_of_words_that_are_not_there_are_left_out() -> None:
    rivals = RivalWords({"x": [[0, 1]]}, {"x": [[2, 1]], "gone": [[2]]}, BLANK, reward=2.0)
    assert rivals.lead("x", *sound(2, 1)) == pytest.approx(5)


def test_a_phone_that_merges_with_the_next_word_makes_no_rival() -> None:
    """Nobody hears "slowed down" beside "slow down"."""
    rivals = RivalWords({"x": [[0, 1]], "y": [[2, 0]]}, {"x": [[0, 1, 2]]}, BLANK, reward=2.0)
    assert rivals.lead("x y", *sound(0, 1, 2, 0)) is None
    assert rivals.lead("x x", *sound(0, 1, 0, 1)) is not None
