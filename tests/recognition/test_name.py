"""Where the robot's name is in a sound, and how surely."""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from recordings import spoken

from voz.audio import SAMPLE_RATE, Samples
from voz.recognition.confidence import sigmoid
from voz.recognition.language import Language, with_more_words
from voz.recognition.name import (
    CONTEXT_WEIGHT,
    LEAST_LIKELY,
    LEAST_LOG_ODDS,
    LENGTH_LIMITS,
    MOST_AGAINST,
    SURE_LOG_ODDS,
    NameEvidence,
    NameFinder,
    NameWeights,
    at_speed,
    find_evidence,
    mean_odds,
    read_weights,
    write_weights,
)
from voz.recognition.network.ctc import Floats, lattice
from voz.recognition.network.score import PhonemeScorer, scorer_for
from voz.recognition.thresholds import NAME_THRESHOLD
from voz.settings import Recognition

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


@pytest.mark.parametrize(("noise", "seed"), [(4, 40), (9, 38)])
def test_a_name_that_is_doubtful_at_its_own_speed_is_found_by_others(
    network: PhonemeScorer, finder: NameFinder, noise: float, seed: int
) -> None:
    samples = said(NAME, noise, seed)
    sounds = network.phone_likelihoods(samples)
    assert finder.best(sounds, alone=True).confidence < NAME_THRESHOLD
    found = finder.find(samples, sounds, alone=True)
    assert found.confidence >= NAME_THRESHOLD
    assert 1.2 < found.begin < found.end < 2.3


@pytest.mark.parametrize(("at", "level"), [(22_000, 0.8), (24_000, 0.9), (18_000, 1.0)])
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


def test_other_words_that_the_network_takes_for_the_name_are_none(
    network: PhonemeScorer, finder: NameFinder
) -> None:
    samples = said("play robin", 0.02, 1)
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
    name = said(NAME, 9, 38)
    samples = np.concatenate([np.zeros(3 * SAMPLE_RATE, np.int16), name, PAUSE.astype(np.int16)])
    sounds = network.phone_likelihoods(samples)
    assert finder.best(sounds).confidence < NAME_THRESHOLD
    found = finder.find(samples, sounds)
    assert found.confidence >= NAME_THRESHOLD
    assert 4.2 < found.begin < found.end < 5.3


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
