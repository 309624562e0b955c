"""The distances of a model's phones by its Gaussians, against those measured on speech."""

from __future__ import annotations

import shutil
from pathlib import Path

import numpy as np
import pocketsphinx
import pytest
from spanish import LIKE, spanish_model

from voz.errors import LanguageError
from voz.language.acoustics.acoustic_model import read_phones, spoken_phones
from voz.language.acoustics.model_distances import compute_distances
from voz.language.acoustics.phone_distances import read_distances

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
