"""What the loudspeaker gives out is taken out of what the microphone hears; the rest stays."""

from __future__ import annotations

import numpy as np
import pytest
import soxr
from recordings import Recording

from voz.apps.evaluation.noise import room_response
from voz.audio import SAMPLE_RATE
from voz.audio.echo import ECHO_EDGE, EchoCanceller
from voz.audio.echo_alignment import MAX_ECHO_DELAY

LENGTH = 3 * SAMPLE_RATE // 2


def decibels(one: np.ndarray, other: np.ndarray) -> float:
    def power(samples: np.ndarray) -> float:
        return float(np.mean(samples[ECHO_EDGE:-ECHO_EDGE].astype(float) ** 2))

    return 10 * np.log10(power(one) / power(other))


@pytest.fixture(scope="module")
def played(session: Recording) -> np.ndarray:
    """Speech, with what was given out before."""
    return session.samples()[SAMPLE_RATE : SAMPLE_RATE + MAX_ECHO_DELAY + LENGTH].astype(float)


def without_silence(recording: Recording) -> np.ndarray:
    samples = recording.samples().astype(float)
    first, last = np.flatnonzero(np.abs(samples) > 300)[[0, -1]]
    return samples[first:last]


@pytest.fixture(scope="module")
def talk(recordings: list[Recording]) -> np.ndarray:
    """As much speech without a pause."""
    clip = next(r for r in recordings if r.text == "turn left" and r.voice == "flite_slt")
    return np.resize(without_silence(clip), MAX_ECHO_DELAY + LENGTH)


def echo_of(played: np.ndarray, delay: float) -> np.ndarray:
    """The last part of it in a room, and late."""
    response = room_response(np.random.default_rng(1))
    late = np.concatenate([np.zeros(round(delay * SAMPLE_RATE)), np.convolve(played, response)])
    return late[MAX_ECHO_DELAY : MAX_ECHO_DELAY + LENGTH]


@pytest.mark.parametrize("delay", [0.0, 0.03, 0.15, 0.3])
def test_an_echo_is_taken_out_however_late_it_is(played: np.ndarray, delay: float) -> None:
    heard = echo_of(played, delay).astype(np.int16)
    rest = EchoCanceller().clean(heard, (played / 32768).astype(np.float32)).samples
    assert len(rest) == len(heard)
    assert decibels(heard, rest) > 12


def test_what_was_said_stays(played: np.ndarray, recordings: list[Recording]) -> None:
    clip = next(r for r in recordings if r.text == "stop" and r.voice == "flite_slt")
    said = np.zeros(LENGTH)
    said[2000 : 2000 + len(clip.samples())] = clip.samples()[: LENGTH - 2000]
    heard = (echo_of(played, 0.05) + 0.5 * said).astype(np.int16)
    rest = EchoCanceller().clean(heard, (played / 32768).astype(np.float32)).samples
    likeness = np.corrcoef(rest[ECHO_EDGE:-ECHO_EDGE], said[ECHO_EDGE:-ECHO_EDGE])[0, 1]
    assert (
        likeness > np.corrcoef(heard[ECHO_EDGE:-ECHO_EDGE], said[ECHO_EDGE:-ECHO_EDGE])[0, 1] + 0.2
    )


@pytest.mark.parametrize("lowest", [0.0, 200.0, 300.0, 450.0])
def test_what_a_small_loudspeaker_adds_is_taken_out(talk: np.ndarray, lowest: float) -> None:
    """It plays nothing below some frequency, and distorts what it plays."""
    hertz = 1j * np.fft.rfftfreq(2 * len(talk), 1 / SAMPLE_RATE)
    gain = hertz**2 / (lowest**2 + 1.2 * lowest * hertz + hertz**2 + 1e-9)
    driven = np.fft.irfft(np.fft.rfft(talk, 2 * len(talk)) * gain)[: len(talk)]
    driven *= 4 / np.abs(driven).max()
    heard = echo_of(3000 * np.tanh(driven + 0.3 * driven**2), 0.05).astype(np.int16)
    rest = EchoCanceller().clean(heard, (talk / 32768).astype(np.float32)).samples
    assert decibels(heard, rest) > 19.5


def test_an_echo_of_a_slow_clock_is_taken_out_when_the_clock_is_known(session: Recording) -> None:
    played = session.samples().astype(np.float32)
    slow = soxr.resample(played, 1.0, 1.001)
    heard = np.concatenate([np.zeros(800), slow]).astype(np.int16)
    canceller = EchoCanceller()
    for begin in range(SAMPLE_RATE, 7 * SAMPLE_RATE, SAMPLE_RATE // 2):
        end = begin + MAX_ECHO_DELAY + LENGTH
        part = heard[end - LENGTH : end]
        rest = canceller.clean(part, played[begin:end] / 32768).samples
    assert decibels(part, rest) > 12


def test_what_was_said_stands_out_of_what_is_left_of_the_echo(
    played: np.ndarray, recordings: list[Recording]
) -> None:
    clip = next(r for r in recordings if r.text == "stop" and r.voice == "flite_slt").samples()
    echo = echo_of(played, 0.05)
    said = echo.copy()
    said[: len(clip)] += clip[:LENGTH]
    wave = (played / 32768).astype(np.float32)
    without = EchoCanceller().clean(echo.astype(np.int16), wave)
    cleaned = EchoCanceller().clean(said.astype(np.int16), wave)
    loud = np.flatnonzero(np.abs(clip) > 0.1 * np.abs(clip).max())
    begin, end = loud[[0, -1]] / SAMPLE_RATE
    assert cleaned.level_above_residue(begin, end) > 5
    assert without.level_above_residue(begin, end) < 2


def test_speech_stays_whole_where_no_echo_is_heard(
    played: np.ndarray, recordings: list[Recording]
) -> None:
    canceller = EchoCanceller()
    wave = (played / 32768).astype(np.float32)
    for clip in (r.samples() for r in recordings if r.voice == "flite_slt"):
        heard = np.random.default_rng(2).normal(0, 8, LENGTH)
        heard[2000 : 2000 + len(clip)] += clip[: LENGTH - 2000]
        rest = canceller.clean(heard.astype(np.int16), wave).samples
        assert np.array_equal(rest, heard.astype(np.int16))
    rest = canceller.clean(echo_of(played, 0.05).astype(np.int16), wave).samples
    assert decibels(echo_of(played, 0.05), rest) > 12  # the headphones were pulled out


def test_where_nothing_was_played_nothing_changes(session: Recording) -> None:
    heard = session.samples()[:LENGTH]
    played = np.zeros(MAX_ECHO_DELAY + LENGTH, np.float32)
    rest = EchoCanceller().clean(heard, played).samples
    assert np.abs(rest - heard.astype(int))[ECHO_EDGE:-ECHO_EDGE].max() <= 1


def test_who_speaks_over_an_echo_is_told_from_it(
    talk: np.ndarray, recordings: list[Recording]
) -> None:
    clip = without_silence(next(r for r in recordings if r.text == "stop"))
    wave = (talk / 32768).astype(np.float32)
    stop = np.zeros(LENGTH)
    stop[8000 : 8000 + len(clip)] = clip[: LENGTH - 8000]
    loud = np.abs(stop) > 0.2 * np.abs(stop).max()
    for level, low, high in ((0.0, 0.8, 1.0), (0.5, 0.0, 0.4)):
        heard = (echo_of(talk, 0.05) + level * stop).astype(np.int16)
        alone = EchoCanceller().clean(heard, wave).may_be_played()
        assert len(alone) == LENGTH
        assert low <= alone[loud].mean() <= high


def test_what_was_played_may_be_heard_where_no_echo_was_found(played: np.ndarray) -> None:
    wave = (played / 32768).astype(np.float32)
    heard = np.random.default_rng(2).normal(0, 8, LENGTH).astype(np.int16)
    assert EchoCanceller().clean(heard, wave).may_be_played().all()
