"""The times of words, and the sentences that fit best."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from recordings import GO_BACK, Recording

import voz
from voz.api.recognizer import Recognizer
from voz.audio import SAMPLE_RATE, Samples
from voz.audio.segment import NO_SAMPLES, Segment
from voz.audio.sound_files import read_blocks, to_samples
from voz.events import Alternative, Utterance, shift_time
from voz.language.language_files import LanguageFiles
from voz.recognition.confidence import SCORE, Context
from voz.recognition.decision import Hypothesis, Requirement, decide
from voz.recognition.interpreter import Details, with_details
from voz.settings import Recognition

BY_NETWORK, ALONE = "network", "pocketsphinx alone"


@pytest.fixture(scope="module", params=[BY_NETWORK, ALONE])
def either(
    request: pytest.FixtureRequest, recognizer: Recognizer, language: LanguageFiles
) -> Recognizer:
    """A recognizer with the network, and one without."""
    if request.param == BY_NETWORK:
        return recognizer
    return Recognizer(language, Recognition(use_network=False))


def test_words_are_said_in_turn_while_there_is_sound(
    either: Recognizer, recordings: list[Recording]
) -> None:
    clips = [r for r in recordings if r.kind == "command" and r.voice == "festival_slt"]
    for clip in clips:
        (heard,) = either.decode(clip.path, words=True)
        assert [each.word for each in heard.words] == heard.text.split() == clip.text.split()
        times = [time for each in heard.words for time in (each.start, each.end)]
        assert times == sorted(times)
        loud = np.flatnonzero(np.abs(clip.samples()) > 1000) / SAMPLE_RATE
        assert times[0] == pytest.approx(loud[0], abs=0.15)
        assert times[-1] == pytest.approx(loud[-1], abs=0.25)


def room(seconds: float) -> Samples:
    noise = np.random.default_rng(0).normal(0, 10, int(seconds * SAMPLE_RATE))
    return to_samples(noise.astype(np.int16), SAMPLE_RATE)


def test_a_pause_between_words_is_where_it_was_put(
    either: Recognizer, recordings: list[Recording]
) -> None:
    pause = 0.2
    for text in ("go back", "point beer", "rotate left"):
        clip = next(r for r in recordings if (r.text, r.voice) == (text, "festival_slt"))
        sound = np.concatenate([room(1.0), clip.samples(), room(1.0)])
        (heard,) = either.decode(sound, rate=SAMPLE_RATE, words=True)
        one, other = heard.words
        at = int((one.end + other.start) / 2 * SAMPLE_RATE)
        parted = np.concatenate([sound[:at], room(pause), sound[at:]])
        (again,) = either.decode(parted, rate=SAMPLE_RATE, words=True)
        assert again.text == text
        assert again.words[0].start == pytest.approx(one.start, abs=0.04)
        assert again.words[1].end == pytest.approx(other.end + pause, abs=0.04)
        assert again.words[1].start == pytest.approx(other.start + pause, abs=0.12)


def test_the_best_sentence_is_what_was_heard_and_the_next_is_the_next_best(
    either: Recognizer, recordings: list[Recording]
) -> None:
    for clip in [r for r in recordings if r.kind == "near-miss"][::9]:
        for heard in either.decode(clip.path, best=5):
            if not heard.best:  # it was compared with no command
                continue
            assert heard.best[0] == Alternative(heard.text, heard.confidence)
            assert 2 <= len({each.text for each in heard.best}) == len(heard.best) <= 5
            assert all(each.text in either.commands for each in heard.best)
            assert heard.next_best == heard.best[1].text
            sure = [each.confidence for each in heard.best]
            assert sure == sorted(sure, reverse=True)
            assert sum(sure) <= 1.003  # each is rounded


def test_there_are_no_more_of_them_than_commands(either: Recognizer) -> None:
    (heard,) = either.decode(GO_BACK, best=100)
    assert len(heard.best) == len(either.commands)
    (heard,) = either.decode(GO_BACK, best=1)
    assert [each.text for each in heard.best] == ["go back"]


def test_what_is_not_asked_for_is_not_there_and_costs_no_search(
    either: Recognizer, monkeypatch: pytest.MonkeyPatch
) -> None:
    asked = either.decode(GO_BACK, words=True, best=3)
    for function in ("network.score.align", "interpreter.with_details"):
        monkeypatch.setattr(f"voz.recognition.{function}", None)
    (plain,) = either.decode(GO_BACK)
    assert (plain.words, plain.best) == ((), ())
    assert [each.text for each in asked] == [plain.text]


def test_what_is_asked_for_is_checked(recognizer: Recognizer) -> None:
    for wrong in (-1, 101, 2.5, "3"):
        with pytest.raises(voz.ConfigError, match="best"):
            recognizer.decode(GO_BACK, best=wrong)  # type: ignore[arg-type]
    with pytest.raises(voz.ConfigError, match="words"):
        recognizer.decode(GO_BACK, words="yes")  # type: ignore[arg-type]


def test_the_words_of_a_later_stream_are_later(recognizer: Recognizer) -> None:
    (heard,) = recognizer.utterances(read_blocks(GO_BACK), "", Details(words=True))
    moved = shift_time(heard, 10.0)
    assert isinstance(moved, Utterance)
    assert [w.start for w in moved.words] == pytest.approx([w.start + 10 for w in heard.words])
    assert moved.end == pytest.approx(heard.end + 10)


def test_words_of_the_trigram_model_that_are_no_command_have_neither(
    language: LanguageFiles, recordings: list[Recording]
) -> None:
    trigrams = Recognizer(language, Recognition(search="lm"))
    session = next(r for r in recordings if r.kind == "near-miss" and len(r.text.split()) > 2)
    heard = trigrams.decode(session.path, words=True, best=3)
    assert all(each.best == () for each in heard if each.text not in trigrams.commands)


@given(
    st.lists(st.floats(0, 1), min_size=1, max_size=9),
    st.sampled_from(Context),
    st.integers(1, 9),
)
def test_confidences_fall_and_are_one_together_at_most(
    likely: list[float], context: Context, count: int
) -> None:
    def others(number: int) -> list[tuple[str, float]]:
        return [("b", each) for each in likely[1:]][:number]

    segment = Segment(0.0, 1.0, 1.0, NO_SAMPLES)
    heard = Hypothesis(segment, "a", 1.0, features={SCORE: 1.0}, others=others)
    first = Utterance(1.0, "a", round(likely[0], 3), False, 0.0, 1.0, "")
    decision = decide(heard, Requirement(None, is_name=False, may_ask=False), context)
    best = with_details(first, decision, Details(best=count)).best
    sure = [each.confidence for each in best]
    assert sure[0] == first.confidence
    assert sure == sorted(sure, reverse=True)
    assert sum(sure) <= 1 + 0.001 * len(sure)
