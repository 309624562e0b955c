"""From speech to a sentence: how sure that is, its details, and whether it is obeyed."""

from __future__ import annotations

import dataclasses
import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from recordings import GO_BACK, Recording

import voz
from voz.api.recognizer import Recognizer
from voz.audio import SAMPLE_RATE, Samples
from voz.audio.segment import NO_SAMPLES, Segment
from voz.audio.segmenter import segments
from voz.audio.sound_files import read_blocks, to_samples
from voz.events import Alternative, Utterance, shift_time
from voz.language.language_files import LanguageFiles
from voz.language.sentences.command_set import plain_commands
from voz.recognition.confidence import SCORE, Context
from voz.recognition.decision import Decision, Hypothesis, Requirement, decide
from voz.recognition.interpreter import Details, Interpreter, with_details
from voz.recognition.language import Language
from voz.recognition.profiles import Profile
from voz.settings import Recognition

ALONE = Recognition(use_network=False)


@pytest.fixture(scope="module")
def interpreter(loaded: Language) -> Interpreter:
    return Interpreter(loaded, Recognition(), Profile())


@pytest.fixture(scope="module")
def alone(loaded: Language) -> Interpreter:
    """Pocketsphinx, which what is known of a speaker helps."""
    return Interpreter(loaded, ALONE, Profile())


@pytest.fixture(scope="module")
def clips(recordings: list[Recording]) -> list[Recording]:
    return [r for r in recordings if r.kind == "command" and r.voice == "festival_slt"]


def segment_of(recording: Recording) -> Segment:
    (segment,) = segments([recording.samples()])
    return segment


def of(recordings: list[Recording], text: str, voice: str = "festival_slt") -> Segment:
    return segment_of(next(r for r in recordings if (r.text, r.voice) == (text, voice)))


def decided(
    interpreter: Interpreter, heard: Hypothesis, around: Context = Context.QUIET
) -> Decision:
    return interpreter.rule.decide(heard, around)


def same(one: Hypothesis, other: Hypothesis) -> bool:
    return (one.text, one.probability, one.features) == (
        other.text,
        other.probability,
        other.features,
    )


@pytest.mark.slow
def test_the_sentence_of_a_segment_is_found_and_believed(
    interpreter: Interpreter, clips: list[Recording]
) -> None:
    heard = [interpreter.understand(segment_of(clip)) for clip in clips]
    assert [each.text for each in heard] == [clip.text for clip in clips]
    assert all(each.features and each.probability > 0.9 for each in heard)


@pytest.mark.slow
def test_it_is_made_once_and_what_it_heard_before_does_not_matter(
    interpreter: Interpreter, clips: list[Recording]
) -> None:
    cut = [segment_of(clip) for clip in clips]
    first = [interpreter.understand(segment) for segment in cut]
    again = [interpreter.understand(segment) for segment in reversed(cut)]
    assert all(same(one, other) for one, other in zip(first, reversed(again), strict=True))


def test_the_last_word_ends_before_the_segment_and_moves_with_it(
    interpreter: Interpreter, clips: list[Recording]
) -> None:
    for clip in clips[:5]:
        segment = segment_of(clip)
        heard = interpreter.understand(segment)
        assert segment.start + 0.2 < heard.spoken_until <= segment.end
        times = {name: getattr(segment, name) + 60 for name in ("start", "end", "decided")}
        later = segment._replace(**times)
        assert interpreter.understand(later).spoken_until == pytest.approx(heard.spoken_until + 60)


def test_what_goes_on_for_longer_than_any_command_is_not_even_searched(
    interpreter: Interpreter, recordings: list[Recording]
) -> None:
    stop = of(recordings, "stop")
    length = interpreter.longest + 0.1
    padded = np.pad(stop.samples, (0, int(length * SAMPLE_RATE) - len(stop.samples)))
    heard = interpreter.understand(Segment(0, length, length, padded))
    assert (heard.text, heard.features, heard.probability) == ("", {}, 0)
    utterance = interpreter.utterance(decided(interpreter, heard), length, "")
    assert (utterance.accepted, utterance.reason) == (False, "not_a_command")


def test_a_list_of_longer_commands_may_take_longer(
    interpreter: Interpreter, loaded: Language
) -> None:
    words = max(len(sentence.split()) for sentence in loaded.commands)
    longer = dataclasses.replace(
        loaded, commands=plain_commands([*loaded.commands, " ".join(["stop"] * (words + 1))])
    )
    patient = Interpreter(longer, ALONE, Profile())
    assert patient.longest > interpreter.longest


def test_a_speaker_who_is_worth_more_trust_gets_it(
    interpreter: Interpreter, loaded: Language, recordings: list[Recording]
) -> None:
    trusted = Interpreter(loaded, Recognition(), Profile(log_odds=math.log(4)))
    segment = next(
        segment_of(r) for r in recordings if r.kind == "near-miss" and r.text.startswith("go")
    )
    doubted, believed = interpreter.understand(segment), trusted.understand(segment)
    assert doubted.speech_probability > 0
    odds = [
        each.probability
        / each.speech_probability
        / (1 - each.probability / each.speech_probability)
        for each in (doubted, believed)
    ]
    assert odds[1] == pytest.approx(4 * odds[0], rel=1e-6)


@pytest.mark.slow
def test_judging_and_accepting_agree_whatever_is_around(
    interpreter: Interpreter, recordings: list[Recording]
) -> None:
    asked = [r for r in recordings if r.kind in ("command", "near-miss")][::7]
    cut = [segment for r in asked for segment in segments([r.samples()])]
    seen = set()
    for heard in map(interpreter.understand, cut):
        for around in Context:
            decision = decided(interpreter, heard, around)
            judged = interpreter.utterance(decision, heard.segment.decided, "")
            assert judged.accepted == decision.accepted
            assert (judged.reason is None) == judged.accepted
            seen.add(judged.accepted)
    assert seen == {True, False}


def test_the_more_is_around_a_command_the_less_sure_it_is(
    interpreter: Interpreter, recordings: list[Recording]
) -> None:
    heard = interpreter.understand(of(recordings, "go back", "espeak_gb"))
    decisions = [decided(interpreter, heard, around) for around in Context]
    sure = [interpreter.utterance(decision, 1, "").confidence for decision in decisions]
    assert sure == sorted(sure, reverse=True)
    assert sure[0] > sure[-1]


def test_an_utterance_says_where_it_was_and_how_long_it_took(
    interpreter: Interpreter, recordings: list[Recording]
) -> None:
    segment = of(recordings, "go forward")
    heard = interpreter.understand(segment)
    when = segment.end + 0.3
    utterance = interpreter.utterance(decided(interpreter, heard), when, "a.wav")
    assert (utterance.source, utterance.t) == ("a.wav", round(when, 3))
    assert (utterance.start, utterance.end) == (round(segment.start, 3), round(segment.end, 3))
    assert utterance.latency == round(when - heard.spoken_until, 3)
    assert utterance.score == round(heard.features[SCORE], 2) > 10
    assert utterance.next_best == heard.next_best in {*interpreter.commands} - {"go forward"}


def test_what_pocketsphinx_finds_alone_has_no_score(
    alone: Interpreter, recordings: list[Recording]
) -> None:
    heard = alone.understand(of(recordings, "go forward"))
    utterance = alone.utterance(decided(alone, heard), heard.segment.decided, "a.wav")
    assert (utterance.text, utterance.accepted) == ("go forward", True)
    assert (utterance.score, utterance.next_best) == (None, heard.next_best)
    assert utterance.next_best in {*alone.commands} - {"go forward"}


def test_a_command_may_go_on_if_another_begins_with_its_words(loaded: Language) -> None:
    two = dataclasses.replace(loaded, commands=plain_commands(["stop", "stop speech"]))
    interpreter = Interpreter(two, ALONE, Profile())
    assert interpreter.has_continuation("stop")
    assert not interpreter.has_continuation("stop speech")
    assert not interpreter.has_continuation("sto")


def test_a_stop_is_spotted_before_it_is_over_and_other_commands_are_not(
    interpreter: Interpreter, alone: Interpreter, recordings: list[Recording]
) -> None:
    stop = of(recordings, "stop")
    assert interpreter.spotter
    spotted = interpreter.spotter.spot(stop.samples)
    assert spotted
    assert spotted.text == "stop"
    assert interpreter.spotter.spot(of(recordings, "rotate right").samples) is None
    assert alone.spotter is None


BY_NETWORK, WITHOUT = "network", "pocketsphinx alone"


@pytest.fixture(scope="module", params=[BY_NETWORK, WITHOUT])
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
