"""The network that recognizes phonemes, and the files of weights that it takes."""

from __future__ import annotations

from itertools import groupby
from pathlib import Path

import numpy as np
import pytest
from recordings import Recording

from voz.recognition.network_file import (
    DEFAULT_NETWORK,
    UnknownNetworkError,
    read_network,
    write_network,
)
from voz.recognition.phoneme_network import (
    BLANK_SYMBOLS,
    SHORTEST,
    PhonemeNetwork,
    spectrum_kernels,
)


@pytest.fixture(scope="module")
def network() -> PhonemeNetwork:
    return PhonemeNetwork()


def test_it_hears_the_phonemes_of_a_word(
    network: PhonemeNetwork, recordings: list[Recording]
) -> None:
    said = next(r for r in recordings if r.text == "stop" and r.voice == "festival_slt")
    best = network.log_probabilities(said.samples()).argmax(axis=1)
    heard = [network.symbols[number] for number, _ in groupby(best)]
    sounds = "".join(symbol for symbol in heard if symbol not in BLANK_SYMBOLS)
    assert ascii(sounds) == ascii("st\N{LATIN SMALL LETTER ALPHA}p")


def test_what_is_short_is_filled_up(network: PhonemeNetwork) -> None:
    assert len(network.log_probabilities(np.zeros(10, np.int16))) == SHORTEST // 320 + 1


def test_its_spectra_are_those_of_a_fourier_transform() -> None:
    real, imaginary = spectrum_kernels()
    sound = np.random.default_rng(0).normal(size=len(real)).astype(np.float32)
    window = np.hanning(len(real) + 1)[:-1]
    expected = np.fft.rfft(sound * window)
    assert sound @ real == pytest.approx(expected.real, abs=1e-3)
    assert sound @ imaginary == pytest.approx(expected.imag, abs=1e-3)


def test_a_file_of_weights_reads_back_as_it_was_written(tmp_path: Path) -> None:
    weights, description, _ = read_network(DEFAULT_NETWORK)
    for name in ("one.npz", "other.npz"):
        write_network(tmp_path / name, weights, description)
    one, other = (read_network(tmp_path / name) for name in ("one.npz", "other.npz"))
    assert one.description == description
    assert one.fingerprint == other.fingerprint
    assert one.weights.keys() == weights.keys()
    assert all(np.array_equal(one.weights[name], tensor) for name, tensor in weights.items())


def test_the_file_that_comes_with_voz_says_where_it_is_from() -> None:
    described = read_network(DEFAULT_NETWORK).description
    assert "hama 1.7" in described.origin
    assert described.licence.startswith("Apache-2.0")


def test_other_weights_have_another_fingerprint(tmp_path: Path) -> None:
    weights, description, before = read_network(DEFAULT_NETWORK)
    changed = {**weights, "last.bias": weights["last.bias"] + 1}
    write_network(tmp_path / "changed.npz", changed, description)
    assert PhonemeNetwork(tmp_path / "changed.npz").fingerprint != before


@pytest.mark.parametrize("kept", [0, 3, 60, 7000, 100_000])
def test_a_file_that_is_cut_off_is_refused(kept: int, tmp_path: Path) -> None:
    (tmp_path / "cut.npz").write_bytes(DEFAULT_NETWORK.read_bytes()[:kept])
    with pytest.raises(UnknownNetworkError, match=r"cut\.npz: holds no phoneme network"):
        PhonemeNetwork(tmp_path / "cut.npz")


def test_a_file_of_another_network_is_refused(tmp_path: Path) -> None:
    weights, description, _ = read_network(DEFAULT_NETWORK)
    narrow = {**weights, "last.bias": weights["last.bias"][:-1]}
    write_network(tmp_path / "narrow.npz", narrow, description)
    with pytest.raises(UnknownNetworkError, match="has symbols that do not fit"):
        PhonemeNetwork(tmp_path / "narrow.npz")
    lacking = {name: tensor for name, tensor in weights.items() if name != "blocks.3.ffn2.fc1.bias"}
    write_network(tmp_path / "lacking.npz", lacking, description)
    with pytest.raises(UnknownNetworkError, match=r"holds no tensor 'blocks\.3\.ffn2\.fc1\.bias'"):
        PhonemeNetwork(tmp_path / "lacking.npz")
