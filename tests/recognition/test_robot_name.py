"""A robot's name, said by festival, and answers to what it asks."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest
from recordings import spoken

import voz
from voz.api.recognizer import Recognizer
from voz.audio import SAMPLE_RATE, Samples
from voz.audio.segment import Segment
from voz.language.build import build
from voz.language.language_files import PACKAGED_FOLDER, LanguageFiles
from voz.recognition.confidence import Context
from voz.recognition.decision import Hypothesis
from voz.recognition.interpreter import Interpreter
from voz.recognition.language import load_language, with_more_words
from voz.recognition.name import usual_log_odds
from voz.recognition.network.score import PhonemeScorer
from voz.recognition.speaker.profiles import Profile

NAME = "hey robot"
PAUSE = np.zeros(SAMPLE_RATE, np.int16)


@pytest.fixture(scope="module")
def named() -> Recognizer:
    settings = voz.Recognition(name=" Hey  Robot", ask="always")
    return Recognizer(LanguageFiles(PACKAGED_FOLDER), settings)


def said(text: str) -> Samples:
    return np.concatenate([PAUSE, spoken(text), PAUSE])


def heard(recognizer: Recognizer, *texts: str) -> list[tuple[str, bool]]:
    sound = np.concatenate([said(text) for text in texts])
    return [(u.text, u.named) for u in recognizer.decode(sound, SAMPLE_RATE) if u.accepted]


def test_the_name_is_heard_alone_and_before_a_command(named: Recognizer) -> None:
    assert named.name == NAME
    assert heard(named, NAME) == [(NAME, True)]
    assert heard(named, f"{NAME}, go forward") == [("go forward", True)]
    assert heard(named, f"{NAME}, stop") == [("stop", True)]
    assert heard(named, NAME, "turn left") == [(NAME, True), ("turn left", False)]


@pytest.mark.parametrize(
    ("soft", "share", "noise"),
    [(0.25, 0.18, 200), (0.25, 0.18, 300), (0.35, 0.18, 200), (0.4, 0.25, 100), (0.45, 0.25, 200)],
)
def test_a_name_that_ends_softly_in_noise_is_heard(
    named: Recognizer, soft: float, share: float, noise: float
) -> None:
    sound = said(NAME).astype(float)
    loud = np.flatnonzero(np.abs(sound) > 300)
    sound[loud[-1] - int(soft * SAMPLE_RATE) :] *= share
    sound += np.random.default_rng(1).normal(0, noise, len(sound))
    (only,) = named.decode(np.rint(sound).astype(np.int16), SAMPLE_RATE)
    assert (only.text, only.named, only.accepted) == (NAME, True, True)


@pytest.mark.parametrize("seed", [1, 3])
def test_a_name_in_noise_that_hides_its_voice_is_heard(named: Recognizer, seed: int) -> None:
    speech = said(NAME).astype(float)
    power = np.mean(speech[SAMPLE_RATE:-SAMPLE_RATE] ** 2)
    sound = np.concatenate([PAUSE, speech])
    sound += np.random.default_rng(seed).normal(0, np.sqrt(4 * power), len(sound))
    (only,) = named.decode(np.rint(sound).astype(np.int16), SAMPLE_RATE)
    assert (only.text, only.accepted) == (NAME, True)


@pytest.mark.parametrize(
    "rest", ["makers have sold a million of them", "parts are cheap these days"]
)
def test_a_name_in_talk_that_goes_on_is_none(named: Recognizer, rest: str) -> None:
    utterances = named.decode(said(f"{NAME} {rest}"), SAMPLE_RATE)
    assert not any(utterance.named for utterance in utterances)


@pytest.mark.parametrize(("rest", "gap"), [("tea for two", 0.2), ("obviously", 0.1), ("tom", 0.1)])
def test_a_name_is_heard_once_whatever_follows(named: Recognizer, rest: str, gap: float) -> None:
    pause = np.zeros(int(gap * SAMPLE_RATE), np.int16)
    sound = np.concatenate([said(NAME)[:-SAMPLE_RATE], pause, said(rest)[SAMPLE_RATE:]])
    utterances = named.decode(sound, SAMPLE_RATE)
    assert [utterance.text for utterance in utterances].count(NAME) == 1


def test_a_name_that_is_said_twice_is_heard_twice(named: Recognizer) -> None:
    sound = np.concatenate([said(NAME)[:-SAMPLE_RATE], said(NAME)[SAMPLE_RATE:]])
    assert [utterance.text for utterance in named.decode(sound, SAMPLE_RATE)] == [NAME, NAME]


@pytest.mark.parametrize("gap", [0.0, 0.2, 0.4])
def test_a_name_lets_no_command_amid_talk_through(
    named: Recognizer, recognizer: Recognizer, gap: float
) -> None:
    talk = [said(text)[SAMPLE_RATE:-SAMPLE_RATE] for text in ("it may rain", "go forward", "soon")]
    pause = np.zeros(int(gap * SAMPLE_RATE), np.int16)
    sound = np.concatenate([PAUSE, talk[0], pause, talk[1], pause, talk[2], PAUSE])
    with_name, without = (
        [(u.text, u.accepted) for u in each.decode(sound, SAMPLE_RATE) if u.accepted]
        for each in (named, recognizer)
    )
    assert with_name == without


def test_what_is_not_surely_the_name_does_not_wake() -> None:
    segment = Segment(0.0, 1.0, 1.2, said(NAME))
    settings = voz.Recognition(name=NAME)
    language = with_more_words(load_language(LanguageFiles(PACKAGED_FOLDER)), settings)
    interpreter = Interpreter(language, settings, Profile(), learning=False)
    for sure in (0.4, 0.6):
        hypothesis = Hypothesis(segment, NAME, 1.0, probability=sure, named=True)
        decision = interpreter.rule.decide(hypothesis, Context.QUIET)
        utterance = interpreter.utterance(decision, 1.2, "microphone")
        assert utterance.accepted == utterance.named == (sure > 0.5)


def test_what_is_said_without_the_name_has_none(named: Recognizer) -> None:
    assert heard(named, "go forward") == [("go forward", False)]
    others = ("the robot is here", "hello there, go forward", "hey", "go forward robot")
    assert not any(name for text in others for _, name in heard(named, text))


def test_answers_are_understood_while_they_are_expected(named: Recognizer) -> None:
    assert heard(named, "yes") == []
    named.expect(("yes", "no"))
    assert heard(named, "yes", "no", "go back") == [
        ("yes", False),
        ("no", False),
        ("go back", False),
    ]
    named.expect(("forward", "back", "no"))
    assert heard(named, "back", "forward") == [("back", False), ("forward", False)]
    named.expect(())
    assert heard(named, "back") == []


def test_what_it_may_be_is_told_only_where_the_robot_asks(
    named: Recognizer, recognizer: Recognizer
) -> None:
    for asking in (named, recognizer):
        (unsure,) = asking.decode(said("bold ham"), SAMPLE_RATE)
        assert not unsure.accepted
        expected = (voz.PossibleCommand("fold arm", "fold arm"),) if asking is named else ()
        assert unsure.perhaps == expected


@pytest.mark.parametrize(
    ("name", "why"),
    [
        ("go forward", 'a command is or begins with "go forward"'),
        ("turn", 'a command is or begins with "turn"'),
        ("r2d2", "write one to five words of letters a to z"),
        ("a b c d e f", "write one to five words of letters a to z"),
    ],
)
def test_a_name_that_cannot_be_used_is_one_line(name: str, why: str) -> None:
    with pytest.raises(voz.ConfigError, match="name") as told:
        Recognizer(LanguageFiles(PACKAGED_FOLDER), voz.Recognition(name=name))
    assert why in str(told.value)


@pytest.mark.parametrize(
    ("others", "why"),
    [
        ({"name": NAME, "use_network": False}, "needs the phoneme network"),
        ({"ask": "always", "use_network": False}, "needs the phoneme network"),
        ({"name": NAME, "search": "lm"}, 'need search = "grammar"'),
    ],
)
def test_a_name_and_questions_need_the_network_and_the_grammar(
    others: dict[str, Any], why: str
) -> None:
    with pytest.raises(voz.ConfigError, match=why):
        Recognizer(LanguageFiles(PACKAGED_FOLDER), voz.Recognition(**others))


def test_a_short_name_is_told_to_be_one(named: Recognizer, recognizer: Recognizer) -> None:
    assert (named.name_advice, recognizer.name_advice) == ("", "")
    short = Recognizer(LanguageFiles(PACKAGED_FOLDER), voz.Recognition(name="Max"))
    assert 'the name "max" has few sounds' in short.name_advice
    assert 'better is "hey max"' in short.name_advice


def test_a_name_that_no_dictionary_has_is_told_to_be_a_guess(tmp_path: Path) -> None:
    list_of_user = tmp_path / "comandos_voz.txt"
    list_of_user.write_text("go forward\nturn left\nstop\n")

    def advice() -> str:
        build(list_of_user, tmp_path)
        return Recognizer(LanguageFiles(tmp_path), voz.Recognition(name="hey hadouken")).name_advice

    guessed = advice()
    assert guessed.startswith('no dictionary has "hadouken" of the name "hey hadouken", and HH AE ')
    assert guessed.endswith("is a guess: correct it in pronunciations.txt beside the command list")
    (tmp_path / "pronunciations.txt").write_text("hadouken  HH AH D OW K EH N\n")
    assert advice() == ""


def test_a_long_name_is_heard_more_surely() -> None:
    said = {"snowboy": "S N OW B OY", "hey": "HH EY", "max": "M AE K S"}
    network = PhonemeScorer({word: [phones.split()] for word, phones in said.items()})
    names = ("max", "hey max", "hey snowboy")
    short, longer, longest = (usual_log_odds(network, name) for name in names)
    assert short < longer < longest


@pytest.mark.parametrize(("name", "command"), [("point deer", "point beer"), ("hey robot", "")])
def test_a_name_that_sounds_like_a_command_is_told_to(name: str, command: str) -> None:
    advice = Recognizer(LanguageFiles(PACKAGED_FOLDER), voz.Recognition(name=name)).name_advice
    expected = f'the name "{name}" sounds like "{command}"; better is one of other sounds'
    assert advice == (expected if command else "")
