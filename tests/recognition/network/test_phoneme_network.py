"""The network that recognizes phonemes, and the files of weights that it takes."""

from __future__ import annotations

import io
import os
import zipfile
from collections.abc import Callable
from itertools import groupby
from pathlib import Path

import msgspec
import numpy as np
import numpy.typing as npt
import pytest
from recordings import Recording

from voz.recognition.network.phoneme_network import (
    BLANK_SYMBOLS,
    DEFAULT_NETWORK,
    DESCRIPTION,
    LONGEST_WINDOW,
    MAX_NETWORK_BYTES,
    MOMENT,
    SHORTEST,
    PhonemeNetwork,
    UnknownNetworkError,
    read_network,
    spectrum_kernels,
    write_network,
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


def test_a_long_sound_is_heard_in_windows_each_in_its_place(
    network: PhonemeNetwork, recordings: list[Recording]
) -> None:
    said = next(r for r in recordings if r.text == "stop" and r.voice == "festival_slt").samples()
    for samples in (said[:0], said, said[:LONGEST_WINDOW]):
        short = network.log_probabilities(samples)
        assert np.array_equal(network.log_probabilities_in_windows(samples), short)
    for times in (3, 4, 7):
        samples = np.tile(said, times)[: -50 * times]
        found = network.log_probabilities_in_windows(samples)
        assert len(found) == len(network.log_probabilities(samples))
        best = found.argmax(axis=1)
        stops = np.flatnonzero((best[1:] != best[:-1]) & (best[1:] == network.symbols.index("p")))
        assert len(stops) == times
        assert np.abs(np.diff(stops) * MOMENT - len(said)).max() <= 2 * MOMENT


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
    assert described.license.startswith("Apache-2.0")


def test_other_weights_have_another_fingerprint(tmp_path: Path) -> None:
    weights, description, before = read_network(DEFAULT_NETWORK)
    changed = {**weights, "last.bias": weights["last.bias"] + 1}
    write_network(tmp_path / "changed.npz", changed, description)
    assert PhonemeNetwork(tmp_path / "changed.npz").fingerprint != before


def test_a_file_may_have_only_what_differs_from_the_network_of_voz(tmp_path: Path) -> None:
    weights, description, identity = read_network(DEFAULT_NETWORK)
    part = {"last.bias": weights["last.bias"] + 1}
    based = msgspec.structs.replace(description, base=identity)
    write_network(tmp_path / "part.npz", part, based)
    whole = read_network(tmp_path / "part.npz")
    assert whole.weights.keys() == weights.keys()
    assert np.array_equal(whole.weights["first.weight"], weights["first.weight"])
    assert whole.weights["last.bias"] == pytest.approx(part["last.bias"], abs=0.01)
    write_network(tmp_path / "part.npz", part, msgspec.structs.replace(description, base="other"))
    with pytest.raises(
        UnknownNetworkError, match=f"completes network other, and voz has {identity}"
    ):
        PhonemeNetwork(tmp_path / "part.npz")


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


Tensors = dict[str, npt.NDArray[np.generic]]


def plain_entries() -> Tensors:
    with np.load(DEFAULT_NETWORK) as entries:
        return dict(entries)


def with_entry(path: Path, name: str, data: bytes) -> None:
    """Write the network of voz with other bytes as one of its entries."""
    with zipfile.ZipFile(DEFAULT_NETWORK) as old, zipfile.ZipFile(path, "w") as new:
        for entry in old.infolist():
            new.writestr(entry.filename, data if entry.filename == name else old.read(entry))


def header(shape: object, kind: str = "<f2") -> bytes:
    text = io.BytesIO()
    described = {"descr": kind, "fortran_order": False, "shape": shape}
    np.lib.format.write_array_header_1_0(text, described)
    return text.getvalue()


@pytest.mark.parametrize(
    ("entry", "why"),
    [
        (header((273_000, 273_000)), "first.bias.npy has another size than it claims"),
        (header((144,)) + bytes(2 * 143), "first.bias.npy has another size than it claims"),
        (header((-144,)) + bytes(2 * 144), "first.bias.npy holds no numbers"),
        (header((0, 2**70)), "first.bias.npy holds no numbers"),
        (header((144,), "|O") + bytes(8 * 144), "first.bias.npy holds no numbers"),
        (header((144,), "<c8") + bytes(8 * 144), "first.bias.npy holds no numbers"),
        (header((145,)) + bytes(2 * 145), "a tensor first.bias of shape"),
        (header(()) + bytes(2), "a tensor"),
        (b"\x93NUMPY\x09\x00", r"first.bias.npy is of version \(9, 0\)"),
        (b"nothing at all", "the magic string is not correct"),
        (b"", "EOF"),
    ],
)
def test_an_entry_that_claims_what_it_does_not_have_is_refused(
    entry: bytes, why: str, tmp_path: Path
) -> None:
    with_entry(tmp_path / "odd.npz", "first.bias.npy", entry)
    with pytest.raises(UnknownNetworkError, match=rf"odd\.npz: h.*{why}"):
        PhonemeNetwork(tmp_path / "odd.npz")


def test_a_file_that_unpacks_to_more_than_any_network_has_is_refused_unread(tmp_path: Path) -> None:
    bomb = {**plain_entries(), "more": np.zeros(MAX_NETWORK_BYTES, np.uint8)}
    np.savez_compressed(tmp_path / "bomb.npz", **bomb)  # type: ignore[arg-type]
    with pytest.raises(UnknownNetworkError, match=r"bomb\.npz: .*larger than 64,000,000 bytes"):
        PhonemeNetwork(tmp_path / "bomb.npz")


@pytest.mark.parametrize("value", [np.nan, np.inf, -np.inf, 1e300])
@pytest.mark.parametrize("kind", [np.float16, np.float64])
@pytest.mark.filterwarnings("ignore:overflow encountered in cast")
def test_weights_that_are_no_numbers_are_refused(
    value: float, kind: type[np.generic], tmp_path: Path
) -> None:
    weights = plain_entries()
    weights["last.bias"] = np.array([*weights["last.bias"][1:], value], kind)
    np.savez(tmp_path / "odd.npz", **weights)  # type: ignore[arg-type]
    with pytest.raises(
        UnknownNetworkError, match=r"odd\.npz: .*last\.bias holds what is no number"
    ):
        PhonemeNetwork(tmp_path / "odd.npz")


@pytest.mark.parametrize(("names", "value"), [(["first.weight"], 3e38), (None, 0.0)])
def test_weights_with_which_nothing_can_be_heard_are_refused(
    names: list[str] | None, value: float, tmp_path: Path
) -> None:
    weights = plain_entries()
    for name in names or [name for name in weights if name != DESCRIPTION]:
        weights[name] = np.full_like(weights[name], value, np.float32)
    np.savez(tmp_path / "deaf.npz", **weights)  # type: ignore[arg-type]
    with pytest.raises(UnknownNetworkError, match=r"deaf\.npz: has weights that hear nothing"):
        PhonemeNetwork(tmp_path / "deaf.npz")


@pytest.mark.parametrize(
    ("change", "why"),
    [
        (lambda tensors: tensors.pop(DESCRIPTION), "it has no description"),
        (lambda tensors: tensors.update({DESCRIPTION: np.zeros(9, np.uint8)}), "JSON is malformed"),
        (
            lambda tensors: tensors.update(bands=tensors["bands"][:, :-1]),
            r"first\.weight of shape \(240, 144\) in place of \(237, 144\)",
        ),
    ],
)
def test_tensors_that_do_not_fit_together_are_refused(
    change: Callable[[Tensors], object], why: str, tmp_path: Path
) -> None:
    weights = plain_entries()
    change(weights)
    np.savez(tmp_path / "odd.npz", **weights)  # type: ignore[arg-type]
    with pytest.raises(UnknownNetworkError, match=why):
        PhonemeNetwork(tmp_path / "odd.npz")


def test_what_is_no_file_is_not_waited_for(tmp_path: Path) -> None:
    os.mkfifo(tmp_path / "pipe")
    for path in (tmp_path, tmp_path / "pipe", Path("/dev/zero"), Path("/dev/full"), Path("a\0b")):
        with pytest.raises(UnknownNetworkError, match="holds no phoneme network"):
            PhonemeNetwork(path)
