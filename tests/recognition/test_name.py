"""Where the robot's name is in a sound, and how surely; what a robot with a name hears."""

from __future__ import annotations

import math
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from recordings import spoken

import voz
from voz.api.recognizer import Recognizer
from voz.audio import SAMPLE_RATE, Samples
from voz.audio.segment import Segment
from voz.language.build import build
from voz.language.language_files import PACKAGED_FOLDER, LanguageFiles
from voz.recognition.confidence import Context, sigmoid
from voz.recognition.decision import Hypothesis
from voz.recognition.interpreter import Interpreter
from voz.recognition.language import Language, load_language, with_more_words
from voz.recognition.name import (
    CONTEXT_WEIGHT,
    LEAST_LIKELY,
    LEAST_LOG_ODDS,
    LENGTH_LIMITS,
    MOST_AGAINST,
    SPEEDS,
    SURE_LOG_ODDS,
    NameEvidence,
    NameFinder,
    NameWeights,
    at_speed,
    find_evidence,
    mean_odds,
    read_weights,
    usual_log_odds,
    write_weights,
)
from voz.recognition.network.ctc import Floats, lattice
from voz.recognition.network.score import PhonemeScorer, scorer_for
from voz.recognition.profiles import Profile
from voz.recognition.thresholds import NAME_THRESHOLD
from voz.settings import Ask, Recognition

PHONES, BLANK = 3, 3
ZERO = LEAST_LIKELY / 2


def sound(*heard: int) -> Floats:
    """A sound in which one symbol is likely at each moment."""
    log_ratios = np.full((len(heard), PHONES + 1), -20.0)
    log_ratios[np.arange(len(heard)), list(heard)] = 0
    return log_ratios


def evidence(log_ratios: Floats, *phones: int) -> NameEvidence:
    nothing = np.zeros(len(log_ratios))
    return find_evidence(log_ratios, nothing, nothing, lattice([[[phones]]], BLANK))


def test_each_phone_has_what_is_heard_while_it_is_said() -> None:
    log_ratios = sound(BLANK, BLANK, 0, 0, BLANK, BLANK, BLANK, 1, BLANK, BLANK, BLANK, 2)
    log_ratios[5, 2] = -1  # two moments after the first phone
    log_ratios[6, 0] = -1  # just before the second one, and no longer with the first
    found = evidence(log_ratios, 0, 1)
    assert (found.begin, found.end, found.fit) == (2, 8, 0)
    assert found.phones.tolist() == [0, 1]
    first, second = (found.heard + ZERO).tolist()
    assert first == [0, LEAST_LIKELY, -1, LEAST_LIKELY]
    assert second == [-1, 0, LEAST_LIKELY, LEAST_LIKELY]
    assert found.lengths.tolist() == np.searchsorted(LENGTH_LIMITS, [5, 3]).tolist()


def test_what_is_said_around_it_is_told_apart() -> None:
    log_ratios = sound(BLANK, 0, 1, BLANK)
    before, behind = np.array([9.0, 2, 9, 9]), np.array([9.0, 9, 3, 9])
    found = find_evidence(log_ratios, before, behind, lattice([[[[0, 1]]]], BLANK))
    assert (found.fit, found.around) == (0, 5)


def test_a_phone_that_comes_twice_is_two() -> None:
    found = evidence(sound(0, BLANK, 0, 0, 1), 0, 0, 1)
    assert found.phones.tolist() == [0, 0, 1]
    assert found.heard.shape == (3, PHONES + 1)


def test_a_name_that_is_longer_than_the_sound_was_not_said() -> None:
    found = evidence(sound(0, 1), 0, 1, 2, 0)
    heard, lengths = np.ones((PHONES, PHONES + 1)), np.ones((PHONES, 10))
    weights = NameWeights(9.0, 0.5, heard, lengths, np.ones(3))
    assert found.phones.size == 0
    assert found.log_odds(weights) == -np.inf


def test_the_log_odds_add_up() -> None:
    heard = np.arange(PHONES * (PHONES + 1), dtype=float).reshape(PHONES, -1)
    lengths = np.arange(PHONES * 10, dtype=float).reshape(PHONES, -1)
    weights = NameWeights(-2.0, 0.5, heard, lengths, np.zeros(PHONES))
    seen = np.array([[1.0, 0, 0, 0], [0, 0, 2.0, 0]])
    found = NameEvidence(-4.0, 5.0, 0, 9, np.array([2, 1]), seen, np.array([3, 0]))
    told = (heard[2, 0] + 2 * heard[1, 2]) + (23 + 10)
    assert found.log_odds(weights) == -2 - 2 - 5 * CONTEXT_WEIGHT + told


def test_weights_are_read_as_they_were_written(tmp_path: Path) -> None:
    usual = read_weights()
    write_weights(usual, tmp_path / "weights.npz")
    again = read_weights(tmp_path / "weights.npz")
    for one, other in zip(usual, again, strict=True):
        np.testing.assert_array_equal(one, other)
    assert again.constant == pytest.approx(usual.constant)


NAME = "hey robot"
PAUSE = np.zeros(SAMPLE_RATE)

TALK = (
    "every morning it takes a cup of tea to the window, "
    "and every evening it finds its way home again"
)


@pytest.fixture(scope="module")
def network(loaded: Language) -> PhonemeScorer:
    return scorer_for(with_more_words(loaded, Recognition(name=NAME)))


@pytest.fixture(scope="module")
def finder(network: PhonemeScorer) -> NameFinder:
    return NameFinder(network, NAME)


def after_a_pause(speech: Samples | Floats, others: Floats) -> Samples:
    """Speech between two pauses, with other sound that is as long and repeated as needed."""
    sound = np.concatenate([PAUSE, speech, PAUSE])
    return np.rint(sound + np.resize(others, len(sound))).clip(-32768, 32767).astype(np.int16)


def said(text: str, noise: float = 0, seed: int = 0) -> Samples:
    """A text after a pause, in noise of so many times its power."""
    speech = spoken(text).astype(float)
    deviation = np.sqrt(noise * np.mean(speech**2))
    length = len(speech) + 2 * len(PAUSE)
    return after_a_pause(speech, np.random.default_rng(seed).normal(0, deviation, length))


def amid_talk(text: str, at: int, level: float) -> Samples:
    """A text after a pause, while another talks, from a sample on, so many times as loud."""
    speech, other = spoken(text), spoken(TALK, "cmu_us_slt_arctic_hts").astype(float)
    return after_a_pause(speech, level * np.std(speech) / np.std(other) * other[at:])


@pytest.mark.parametrize(("noise", "seed"), [(6, 14), (9, 38)])
def test_a_name_that_is_doubtful_at_its_own_speed_is_found_by_others(
    network: PhonemeScorer, finder: NameFinder, noise: float, seed: int
) -> None:
    samples = said(NAME, noise, seed)
    sounds = network.phone_likelihoods(samples)
    assert finder.best(sounds, alone=True).confidence < NAME_THRESHOLD
    found = finder.find(samples, sounds, alone=True)
    assert found.confidence >= NAME_THRESHOLD
    assert 1.2 < found.begin < found.end < 2.3


@pytest.mark.parametrize(("at", "level"), [(40_000, 0.7), (24_000, 0.9), (18_000, 1.0)])
def test_a_name_amid_talk_of_which_the_network_is_not_sure_is_found_by_pocketsphinx(
    network: PhonemeScorer, finder: NameFinder, at: int, level: float
) -> None:
    samples = amid_talk(NAME, at, level)
    sounds = network.phone_likelihoods(samples)
    found = finder.find(samples, sounds)
    assert found.confidence >= NAME_THRESHOLD
    at_one_speed = finder.best(sounds)
    assert at_one_speed.confidence < NAME_THRESHOLD
    by_network = found.log_odds - finder.by_pocketsphinx(samples, at_one_speed)
    assert sigmoid(by_network) < NAME_THRESHOLD


def test_a_doubtful_name_that_one_speed_settles_is_not_heard_at_others_nor_by_pocketsphinx(
    network: PhonemeScorer, finder: NameFinder, monkeypatch: pytest.MonkeyPatch
) -> None:
    samples = said(NAME, 6, 14)
    sounds = network.phone_likelihoods(samples)
    at_all = [finder.best(sounds).log_odds]
    for speed in SPEEDS:
        heard = network.phone_likelihoods(at_speed(samples, speed))
        at_all.append(finder.best(heard).log_odds)
    monkeypatch.setattr(finder, "by_pocketsphinx", None)
    found = finder.find(samples, sounds)
    assert sigmoid(found.log_odds - MOST_AGAINST) >= NAME_THRESHOLD
    assert found.log_odds <= mean_odds(at_all) + 0.5  # of a shorter sound


def test_other_words_that_the_network_takes_for_the_name_are_none(
    network: PhonemeScorer, finder: NameFinder
) -> None:
    samples = said("play robin", 0.5, 1)
    sounds = network.phone_likelihoods(samples)
    assert finder.best(sounds, alone=True).confidence >= NAME_THRESHOLD
    assert finder.find(samples, sounds, alone=True).confidence < NAME_THRESHOLD


def test_in_loud_noise_pocketsphinx_says_little_against_a_name(
    network: PhonemeScorer, finder: NameFinder
) -> None:
    samples = said(NAME, 9, 38)
    match = finder.best(network.phone_likelihoods(samples), alone=True)
    assert finder.by_pocketsphinx(samples, match) == -MOST_AGAINST


def test_a_name_in_talk_that_goes_on_is_not_made_likelier(
    network: PhonemeScorer, finder: NameFinder
) -> None:
    samples = said(f"{NAME} makers have sold a million of them")
    match = finder.best(network.phone_likelihoods(samples), alone=True)
    assert match.log_odds < 0 < match.log_odds + match.against
    assert finder.by_pocketsphinx(samples, match) == 0


@pytest.mark.parametrize("text", [NAME, "the kettle is on", "go back"])
def test_what_is_sure_is_heard_at_its_own_speed_alone(
    network: PhonemeScorer, finder: NameFinder, text: str
) -> None:
    samples = said(text)
    sounds = network.phone_likelihoods(samples)
    best = finder.best(sounds)
    assert not LEAST_LOG_ODDS < best.log_odds < SURE_LOG_ODDS
    assert finder.find(samples, sounds) == best


@pytest.mark.parametrize(("noise", "seed"), [(0.3, 5), (0.3, 15), (0.3, 30)])
def test_a_name_does_not_end_in_the_words_behind_it(
    network: PhonemeScorer, finder: NameFinder, noise: float, seed: int
) -> None:
    # The T of "hey robot" is heard better in "triple shot": the words before would be lost.
    samples = said(f"{NAME} brew a triple shot light roast house coffee", noise, seed)
    match = finder.best(network.phone_likelihoods(samples))
    assert match.log_odds > 0
    assert match.end <= 2.0


def test_a_name_with_a_pause_between_its_words_ends_behind_the_last(
    network: PhonemeScorer, finder: NameFinder
) -> None:
    first, second = (spoken(word) for word in NAME.split())
    samples = np.concatenate([PAUSE, first, PAUSE, second, PAUSE]).astype(np.int16)
    match = finder.best(network.phone_likelihoods(samples))
    assert match.end > (2 * len(PAUSE) + len(first)) / SAMPLE_RATE


def test_a_name_that_ended_earlier_is_none(network: PhonemeScorer, finder: NameFinder) -> None:
    samples = said(NAME, 9, 38)
    sounds = network.phone_likelihoods(samples)
    found = finder.find(samples, sounds)
    assert found.confidence >= NAME_THRESHOLD
    again = finder.find(samples, sounds, earliest_end=found.end)
    assert again.confidence >= NAME_THRESHOLD
    later = finder.find(samples, sounds, earliest_end=found.end + 0.9)
    assert later.confidence < NAME_THRESHOLD


def test_a_doubtful_name_is_found_where_it_is_in_a_long_sound(
    network: PhonemeScorer, finder: NameFinder
) -> None:
    name = said(NAME, 6, 30)
    samples = np.concatenate([np.zeros(3 * SAMPLE_RATE, np.int16), name, PAUSE.astype(np.int16)])
    sounds = network.phone_likelihoods(samples)
    assert finder.best(sounds).confidence < NAME_THRESHOLD
    found = finder.find(samples, sounds)
    assert found.confidence >= NAME_THRESHOLD
    assert 4.2 < found.begin < found.end < 5.3


def test_a_doubtful_name_with_nothing_behind_it_is_not_looked_for_again(
    network: PhonemeScorer, finder: NameFinder
) -> None:
    samples = said(NAME, 9, 38)
    sounds = network.phone_likelihoods(samples)
    found = finder.find(samples, sounds)
    assert finder.find_alone(samples, sounds, 1.0, found, 0.4) is found
    talk = said(f"{NAME} makers have sold a million of them")
    sounds = network.phone_likelihoods(talk)
    found = finder.find(talk, sounds)
    alone = finder.find_alone(talk, sounds, 1.0, found, 0.4)
    assert alone == finder.find(talk, sounds, 1.0, alone=True) != found


@pytest.mark.parametrize("speed", [0.89, 1.12])
def test_sound_at_another_speed_is_higher_and_shorter_by_as_much(speed: float) -> None:
    tone = np.sin(2 * np.pi * 500 * np.arange(SAMPLE_RATE) / SAMPLE_RATE)
    played = at_speed((10000 * tone).astype(np.int16), speed)
    assert played.dtype == np.int16
    assert len(played) == pytest.approx(SAMPLE_RATE / speed, abs=2)
    loudest = np.abs(np.fft.rfft(played)).argmax() * SAMPLE_RATE / len(played)
    assert loudest == pytest.approx(500 * speed, abs=2)


@given(st.lists(st.floats(-50, 50), min_size=1))
def test_the_mean_of_odds_is_that_of_their_exponentials(log_odds: list[float]) -> None:
    expected = math.log(sum(map(math.exp, log_odds)) / len(log_odds))
    assert mean_odds(log_odds) == pytest.approx(expected)
    assert min(log_odds) - 1e-9 <= mean_odds(log_odds) <= max(log_odds) + 1e-9


def test_odds_of_nothing_add_nothing() -> None:
    assert mean_odds([0.0, -math.inf]) == pytest.approx(-math.log(2))


ROBOT_NAME = "hey robot"
SECOND = np.zeros(SAMPLE_RATE, np.int16)


@pytest.fixture(scope="module")
def named() -> Recognizer:
    settings = voz.Recognition(name=" Hey  Robot", ask="always")
    return Recognizer(LanguageFiles(PACKAGED_FOLDER), settings)


def amid_silence(text: str) -> Samples:
    return np.concatenate([SECOND, spoken(text), SECOND])


def heard(recognizer: Recognizer, *texts: str) -> list[tuple[str, bool]]:
    sound = np.concatenate([amid_silence(text) for text in texts])
    return [(u.text, u.named) for u in recognizer.decode(sound, SAMPLE_RATE) if u.accepted]


def test_the_name_is_heard_alone_and_before_a_command(named: Recognizer) -> None:
    assert named.name == ROBOT_NAME
    assert heard(named, ROBOT_NAME) == [(ROBOT_NAME, True)]
    assert heard(named, f"{ROBOT_NAME}, go forward") == [("go forward", True)]
    assert heard(named, f"{ROBOT_NAME}, stop") == [("stop", True)]
    assert heard(named, ROBOT_NAME, "turn left") == [(ROBOT_NAME, True), ("turn left", False)]


@pytest.mark.parametrize(
    ("soft", "share", "noise"),
    [(0.25, 0.18, 200), (0.25, 0.18, 300), (0.35, 0.18, 200), (0.4, 0.25, 100), (0.45, 0.25, 200)],
)
def test_a_name_that_ends_softly_in_noise_is_heard(
    named: Recognizer, soft: float, share: float, noise: float
) -> None:
    sound = amid_silence(ROBOT_NAME).astype(float)
    loud = np.flatnonzero(np.abs(sound) > 300)
    sound[loud[-1] - int(soft * SAMPLE_RATE) :] *= share
    sound += np.random.default_rng(1).normal(0, noise, len(sound))
    (only,) = named.decode(np.rint(sound).astype(np.int16), SAMPLE_RATE)
    assert (only.text, only.named, only.accepted) == (ROBOT_NAME, True, True)


@pytest.mark.parametrize("seed", [1, 3])
def test_a_name_in_noise_that_hides_its_voice_is_heard(named: Recognizer, seed: int) -> None:
    speech = amid_silence(ROBOT_NAME).astype(float)
    power = np.mean(speech[SAMPLE_RATE:-SAMPLE_RATE] ** 2)
    sound = np.concatenate([SECOND, speech])
    sound += np.random.default_rng(seed).normal(0, np.sqrt(4 * power), len(sound))
    (only,) = named.decode(np.rint(sound).astype(np.int16), SAMPLE_RATE)
    assert (only.text, only.accepted) == (ROBOT_NAME, True)


@pytest.mark.parametrize(
    "rest", ["makers have sold a million of them", "parts are cheap these days"]
)
def test_a_name_in_talk_that_goes_on_is_none(named: Recognizer, rest: str) -> None:
    utterances = named.decode(amid_silence(f"{ROBOT_NAME} {rest}"), SAMPLE_RATE)
    assert not any(utterance.named for utterance in utterances)


@pytest.mark.parametrize(("rest", "gap"), [("tea for two", 0.2), ("obviously", 0.1), ("tom", 0.1)])
def test_a_name_is_heard_once_whatever_follows(named: Recognizer, rest: str, gap: float) -> None:
    pause = np.zeros(int(gap * SAMPLE_RATE), np.int16)
    sound = np.concatenate(
        [amid_silence(ROBOT_NAME)[:-SAMPLE_RATE], pause, amid_silence(rest)[SAMPLE_RATE:]]
    )
    utterances = named.decode(sound, SAMPLE_RATE)
    assert [utterance.text for utterance in utterances].count(ROBOT_NAME) == 1


def test_a_name_that_is_said_twice_is_heard_twice(named: Recognizer) -> None:
    sound = np.concatenate(
        [amid_silence(ROBOT_NAME)[:-SAMPLE_RATE], amid_silence(ROBOT_NAME)[SAMPLE_RATE:]]
    )
    assert [utterance.text for utterance in named.decode(sound, SAMPLE_RATE)] == [
        ROBOT_NAME,
        ROBOT_NAME,
    ]


@pytest.mark.parametrize("gap", [0.0, 0.2, 0.4])
def test_a_name_lets_no_command_amid_talk_through(
    named: Recognizer, recognizer: Recognizer, gap: float
) -> None:
    talk = [
        amid_silence(text)[SAMPLE_RATE:-SAMPLE_RATE]
        for text in ("it may rain", "go forward", "soon")
    ]
    pause = np.zeros(int(gap * SAMPLE_RATE), np.int16)
    sound = np.concatenate([SECOND, talk[0], pause, talk[1], pause, talk[2], SECOND])
    with_name, without = (
        [(u.text, u.accepted) for u in each.decode(sound, SAMPLE_RATE) if u.accepted]
        for each in (named, recognizer)
    )
    assert with_name == without


def test_what_is_not_surely_the_name_does_not_wake() -> None:
    segment = Segment(0.0, 1.0, 1.2, amid_silence(ROBOT_NAME))
    settings = voz.Recognition(name=ROBOT_NAME)
    language = with_more_words(load_language(LanguageFiles(PACKAGED_FOLDER)), settings)
    interpreter = Interpreter(language, settings, Profile())
    for sure in (0.4, 0.6):
        hypothesis = Hypothesis(segment, ROBOT_NAME, 1.0, probability=sure, named=True)
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


@pytest.mark.parametrize("ask", ["never", "always"])
def test_what_it_may_be_is_told_only_where_the_robot_asks(ask: Ask) -> None:
    settings = voz.Recognition(ask=ask, threshold=0.7)
    recognizer = Recognizer(LanguageFiles(PACKAGED_FOLDER), settings)
    (unsure,) = recognizer.decode(amid_silence("turn it left"), SAMPLE_RATE)
    assert not unsure.accepted
    expected = (voz.PossibleCommand("turn left", "turn left"),) if ask == "always" else ()
    assert unsure.perhaps == expected


@pytest.mark.parametrize(
    ("name", "why"),
    [
        ("go forward", 'a command is or begins with "go forward"'),
        ("turn", 'a command is or begins with "turn"'),
        ("r2d2", "write one to five words of letters"),
        ("a b c d e f", "write one to five words of letters"),
    ],
)
def test_a_name_that_cannot_be_used_is_one_line(name: str, why: str) -> None:
    with pytest.raises(voz.ConfigError, match="name") as told:
        Recognizer(LanguageFiles(PACKAGED_FOLDER), voz.Recognition(name=name))
    assert why in str(told.value)


@pytest.mark.parametrize(
    ("others", "why"),
    [
        ({"name": ROBOT_NAME, "use_network": False}, "needs the phoneme network"),
        ({"ask": "always", "use_network": False}, "needs the phoneme network"),
        ({"name": ROBOT_NAME, "search": "lm"}, 'need search = "grammar"'),
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
    amid_silence = {"snowboy": "S N OW B OY", "hey": "HH EY", "max": "M AE K S"}
    network = PhonemeScorer({word: [phones.split()] for word, phones in amid_silence.items()})
    names = ("max", "hey max", "hey snowboy")
    short, longer, longest = (usual_log_odds(network, name) for name in names)
    assert short < longer < longest


@pytest.mark.parametrize(("name", "command"), [("point deer", "point beer"), ("hey robot", "")])
def test_a_name_that_sounds_like_a_command_is_told_to(name: str, command: str) -> None:
    advice = Recognizer(LanguageFiles(PACKAGED_FOLDER), voz.Recognition(name=name)).name_advice
    expected = f'the name "{name}" sounds like "{command}"; better is one of other sounds'
    assert advice == (expected if command else "")
