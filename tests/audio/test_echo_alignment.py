"""What was played is found in what the microphone hears, however late and by whatever clock."""

from __future__ import annotations

import numpy as np
import pytest
import soxr
from recordings import Recording

from voz.audio import SAMPLE_RATE
from voz.audio.echo_alignment import MAX_ECHO_DELAY, EchoAligner

WINDOW = 2 * SAMPLE_RATE


@pytest.fixture(scope="module")
def speech(session: Recording) -> np.ndarray:
    return session.samples().astype(np.float32)


def likeness(one: np.ndarray, other: np.ndarray) -> float:
    return float(np.corrcoef(one, other)[0, 1])


@pytest.mark.parametrize("delay", [0, 500, 6000])
def test_it_finds_the_delay(speech: np.ndarray, delay: int) -> None:
    played = speech[SAMPLE_RATE : SAMPLE_RATE + MAX_ECHO_DELAY + WINDOW]
    expected = played[MAX_ECHO_DELAY - delay :][:WINDOW]
    aligner = EchoAligner()
    assert np.array_equal(aligner.align(expected.astype(np.int16), played), expected)
    assert aligner.is_heard


def test_other_speech_is_no_echo(speech: np.ndarray, recordings: list[Recording]) -> None:
    played = speech[SAMPLE_RATE : SAMPLE_RATE + MAX_ECHO_DELAY + WINDOW]
    aligner = EchoAligner()
    for clip in (r.samples() for r in recordings if r.voice == "flite_slt"):
        heard = np.random.default_rng(1).normal(0, 8, WINDOW)
        heard[-len(clip) :] += clip[-WINDOW:]
        aligner.align(heard.astype(np.int16), played)
        assert not aligner.is_heard


@pytest.mark.parametrize("drift", [-1e-3, -1e-4, 0.0, 1e-4, 1e-3])
def test_it_learns_how_a_clock_drifts(speech: np.ndarray, drift: float) -> None:
    slow = soxr.resample(speech, 1.0, 1.0 + drift)
    heard = np.pad(slow, (SAMPLE_RATE // 10, 0)).astype(np.int16)
    aligner = EchoAligner()
    for end in range(3 * SAMPLE_RATE, 5 * SAMPLE_RATE, SAMPLE_RATE // 4):
        window = heard[end - WINDOW : end]
        aligned = aligner.align(window, speech[end - WINDOW - MAX_ECHO_DELAY : end])
    assert likeness(aligned, window) > 0.9
