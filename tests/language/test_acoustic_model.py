"""What the acoustic model's files say, beside what pocketsphinx makes of them."""

from __future__ import annotations

import shutil
import struct
from pathlib import Path

import numpy as np
import pocketsphinx
import pytest
from spanish import LIKE, spanish_model

from voz.errors import LanguageError
from voz.language.acoustic_model import (
    CEPSTRA,
    FEATURE_STREAMS,
    VARIANCE_FLOOR,
    AcousticModel,
    compute_distances,
    read_phones,
    spoken_phones,
)
from voz.language.phones import read_distances
from voz.language.spoken_language import ENGLISH_MODEL
from voz.recognition.language import Language

FOLDER = Path(pocketsphinx.get_model_path(ENGLISH_MODEL))


@pytest.fixture(scope="module")
def model() -> AcousticModel:
    return AcousticModel(FOLDER)


def test_a_missing_or_broken_acoustic_model_is_one_clear_line(tmp_path: Path) -> None:
    with pytest.raises(LanguageError, match="mdef"):
        AcousticModel(tmp_path)
    for name in ("mdef", "means", "variances", "sendump"):
        (tmp_path / name).write_bytes(b"nothing of the kind")
    with pytest.raises(LanguageError, match="install pocketsphinx again"):
        AcousticModel(tmp_path)


def test_each_phone_of_the_dictionary_has_gaussians_of_its_own(
    model: AcousticModel, loaded: Language
) -> None:
    said = {phone for phones in loaded.dictionary.values() for phone in phones}
    assert said | {"SIL"} <= set(model.phones)
    assert sorted(model.phones.values()) == list(range(len(model.means)))
    assert model.means.shape[1::2] == (FEATURE_STREAMS, CEPSTRA)
    assert model.variances.shape == model.means.shape


def test_no_variance_is_less_than_the_least_of_pocketsphinx(model: AcousticModel) -> None:
    assert model.variances.min() >= VARIANCE_FLOOR


def test_the_weights_of_a_state_are_shares_of_one(model: AcousticModel) -> None:
    weights = np.exp(model.log_weights(np.arange(0, 5000, 50)))
    assert weights.shape == (FEATURE_STREAMS, 100, model.means.shape[2])
    assert np.allclose(weights.sum(axis=2), 1, atol=0.1)  # they are kept in steps of a tenth


def test_the_weights_are_those_of_the_states_in_their_order(model: AcousticModel) -> None:
    forwards = np.array([7, 300, 4000])
    assert np.array_equal(
        model.log_weights(forwards)[:, ::-1], model.log_weights(forwards[::-1].copy())
    )


@pytest.fixture
def copied(tmp_path: Path) -> Path:
    for name in ("mdef", "means", "variances", "sendump"):
        shutil.copy(FOLDER / name, tmp_path)
    return tmp_path


def replaced_in(path: Path, old: bytes, new: bytes) -> None:
    data = path.read_bytes()
    assert old in data
    path.write_bytes(data.replace(old, new, 1))


def test_a_model_in_the_other_byte_order_is_refused(copied: Path) -> None:
    replaced_in(copied / "means", struct.pack("<I", 0x11223344), struct.pack(">I", 0x11223344))
    with pytest.raises(LanguageError, match="Gaussians of another kind"):
        AcousticModel(copied)


def test_streams_of_another_length_are_refused(copied: Path) -> None:
    replaced_in(copied / "variances", struct.pack("<3i", 13, 13, 13), struct.pack("<3i", 12, 24, 3))
    with pytest.raises(LanguageError, match="Gaussians of another kind"):
        AcousticModel(copied)


@pytest.mark.parametrize("name", ["mdef", "means", "variances", "sendump"])
def test_a_file_that_was_cut_short_is_one_line(name: str, copied: Path) -> None:
    data = (copied / name).read_bytes()
    (copied / name).write_bytes(data[: len(data) // 3 if name != "mdef" else 60])
    with pytest.raises(LanguageError, match="install pocketsphinx again") as caught:
        AcousticModel(copied)
    assert "\n" not in str(caught.value)


def test_files_of_different_models_are_refused(copied: Path) -> None:
    """One phone less in `means` than the definition of the model has."""
    data = (copied / "means").read_bytes()
    at = data.index(b"endhdr\n") + len(b"endhdr\n")
    order, phones, streams, gaussians = struct.unpack_from("<I3i", data, at)
    counts = struct.pack("<I3i", order, phones - 1, streams, gaussians)
    (copied / "means").write_bytes(data[:at] + counts + data[at + 16 :])
    with pytest.raises(LanguageError, match="another number of phones in mdef than in means"):
        AcousticModel(copied)


@pytest.mark.parametrize("name", ["means", "variances"])
@pytest.mark.parametrize("value", [np.nan, np.inf])
def test_gaussians_that_are_no_numbers_are_refused(name: str, value: float, copied: Path) -> None:
    data = (copied / name).read_bytes()
    (copied / name).write_bytes(data[:-8] + struct.pack("<f", value) + data[-4:])
    with pytest.raises(LanguageError, match="values that are no numbers"):
        AcousticModel(copied)


@pytest.mark.parametrize("counts", [(2**31 - 1, 3, 2**31 - 1), (-1, 3, 1), (10**6, 3, 128)])
def test_a_file_that_claims_more_than_it_has_is_refused(
    counts: tuple[int, int, int], copied: Path
) -> None:
    data = (copied / "means").read_bytes()
    at = data.index(b"endhdr\n") + len(b"endhdr\n") + 4
    (copied / "means").write_bytes(data[:at] + struct.pack("<3i", *counts) + data[at + 12 :])
    with pytest.raises(LanguageError, match="another number of values than it claims"):
        AcousticModel(copied)


def test_a_text_of_negative_length_does_not_keep_the_reader_for_ever(copied: Path) -> None:
    data = (copied / "sendump").read_bytes()
    (copied / "sendump").write_bytes(struct.pack("<i", -4) + data[4:])
    with pytest.raises(LanguageError, match="cannot be used"):
        AcousticModel(copied)


def test_a_file_larger_than_any_model_is_not_read(copied: Path) -> None:
    with (copied / "means").open("r+b") as file:
        file.truncate(10**12)
    with pytest.raises(LanguageError, match="means: is larger than 100,000,000 bytes"):
        AcousticModel(copied)


ENGLISH = Path(pocketsphinx.get_model_path("en-us/en-us"))


@pytest.mark.slow
def test_the_distances_of_english_are_much_as_they_were_measured() -> None:
    measured, found = read_distances(), compute_distances(ENGLISH)
    phones = sorted(measured.frames)
    assert sorted(found.frames) == phones
    pairs = [(p, q) for p in phones for q in phones if p != q]
    one = np.array([measured.apart[p][q] for p, q in pairs])
    other = np.array([found.apart[p][q] for p, q in pairs])
    assert np.corrcoef(one, other)[0, 1] > 0.8
    assert 0.9 < one.mean() / other.mean() < 1.1
    assert all(found.apart[phone][phone] == 0 for phone in phones)


def test_the_phones_are_read_from_text_and_from_the_binary_format(tmp_path: Path) -> None:
    assert read_phones(spanish_model(tmp_path / "es")) == list(LIKE)
    assert sorted(spoken_phones(read_phones(ENGLISH))) == sorted(read_distances().frames)


def test_phones_with_the_same_gaussians_are_no_distance_apart(tmp_path: Path) -> None:
    found = compute_distances(spanish_model(tmp_path / "es"))
    assert found.apart["gn"]["n"] < 0.7  # both are N: what is left is chance
    assert found.apart["a"]["s"] > 5
    assert found.frames["gn"] == found.frames["n"]


def test_of_a_model_with_other_gaussians_all_phones_are_equally_far(tmp_path: Path) -> None:
    model = spanish_model(tmp_path / "es")
    (model / "sendump").rename(model / "mixture_weights")
    apart = compute_distances(model).apart
    assert {apart[p][q] for p in apart for q in apart if p != q} == {6.0}


@pytest.mark.parametrize("text", [b"", b"0.3\nno phones\n", b"BMDF", b"something else entirely"])
def test_what_is_no_model_is_one_clear_line(text: bytes, tmp_path: Path) -> None:
    (tmp_path / "mdef").write_bytes(text)
    with pytest.raises(LanguageError, match="acoustic model cannot be used"):
        compute_distances(tmp_path)
    shutil.rmtree(tmp_path)
    with pytest.raises(LanguageError, match="No such file"):
        compute_distances(tmp_path)
