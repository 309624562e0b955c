"""The network gives with numpy what its package gives with its own engine."""

from __future__ import annotations

from importlib.util import find_spec
from itertools import groupby
from pathlib import Path

import numpy as np
import pytest
from recordings import Recording

from voz.recognition import hama_weights, phoneme_network
from voz.recognition.hama_weights import UnknownNetworkError
from voz.recognition.phoneme_engine import PhonemeEngine, load_network
from voz.recognition.phoneme_network import BESIDES, SHORTEST, PhonemeNetwork


@pytest.fixture(scope="module")
def network() -> PhonemeNetwork:
    return PhonemeNetwork()


def test_the_same_comes_out_as_of_the_package(
    network: PhonemeNetwork, recordings: list[Recording]
) -> None:
    engine = PhonemeEngine()
    assert network.symbols == engine.symbols
    loud = np.random.default_rng(0).normal(0, 9000, SHORTEST).clip(-32768, 32767)
    clips = [r.samples()[:32000] for r in recordings[::40]]
    for sound in [*clips, loud.astype(np.int16), np.zeros(SHORTEST, np.int16)]:
        ours, theirs = (n.log_probabilities(sound) for n in (network, engine))
        assert ours.dtype == np.float32
        assert np.exp(ours) == pytest.approx(np.exp(theirs), abs=0.03)
        assert (ours.argmax(axis=1) == theirs.argmax(axis=1)).mean() > 0.97


def test_it_hears_the_phonemes_of_a_word(
    network: PhonemeNetwork, recordings: list[Recording]
) -> None:
    said = next(r for r in recordings if r.text == "stop" and r.voice == "festival_slt")
    best = network.log_probabilities(said.samples()).argmax(axis=1)
    heard = [network.symbols[number] for number, _ in groupby(best)]
    sounds = "".join(symbol for symbol in heard if symbol not in BESIDES)
    assert ascii(sounds) == ascii("st\N{LATIN SMALL LETTER ALPHA}p")


def test_what_is_short_is_filled_up(network: PhonemeNetwork) -> None:
    assert len(network.log_probabilities(np.zeros(10, np.int16))) == SHORTEST // 320 + 1


def test_the_package_may_be_missing(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(hama_weights, "find_spec", lambda name: None)
    with pytest.raises(UnknownNetworkError, match="not installed"):
        PhonemeNetwork()


@pytest.mark.parametrize("kept", [0, 3, 60, 7000, 100_000])
def test_of_another_network_the_engine_of_the_package_is_taken(
    kept: int, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    package = find_spec("hama")
    assert package
    assert package.submodule_search_locations
    assets = Path(package.submodule_search_locations[0]) / "assets"
    (tmp_path / "g2p_vocab.json").write_bytes((assets / "g2p_vocab.json").read_bytes())
    whole = (assets / "asr_waveform.hama").read_bytes()
    (tmp_path / "asr_waveform.hama").write_bytes(whole[:kept])
    monkeypatch.setattr(phoneme_network, "find_assets", lambda: tmp_path)
    with pytest.raises(UnknownNetworkError):
        PhonemeNetwork()
    assert isinstance(load_network(), PhonemeEngine)
