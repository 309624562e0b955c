"""The transform of the acoustic model: what is known of it, and that pocketsphinx reads it."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pocketsphinx
import pytest
from recordings import Recording

from voz.language.acoustic_model import CEPSTRA, AcousticModel
from voz.language.spoken_language import ENGLISH_MODEL
from voz.recognition.decoder import Decoder, mean_start
from voz.recognition.language import Language
from voz.recognition.speaker.adaptation import Aligned
from voz.recognition.speaker.mllr import as_text, fit_transforms, is_transforms


@pytest.fixture(scope="module")
def model() -> AcousticModel:
    return AcousticModel(Path(pocketsphinx.get_model_path(ENGLISH_MODEL)))


def spoken_by_the_model(model: AcousticModel, moved_by: float) -> Aligned:
    """Frames as the model expects them most, 20 of each of its phones, all moved by the same."""
    phones = np.repeat(np.arange(len(model.phones)), 20)
    senones = np.repeat(np.arange(len(model.phones)) * 3, 20)  # of phones without context
    gaussians = model.log_weights(senones)[0].argmax(axis=1)
    cepstra = model.means[phones, 0, gaussians] + moved_by
    return Aligned(cepstra, np.arange(len(phones)), phones, senones)


def test_without_speech_nothing_is_transformed(model: AcousticModel) -> None:
    for matrix, bias in fit_transforms([], model):
        assert np.allclose(matrix, np.eye(CEPSTRA), atol=1e-6)
        assert np.allclose(bias, 0, atol=1e-6)


def test_a_speaker_who_is_moved_is_found(model: AcousticModel) -> None:
    usual = model.means[:, 0].reshape(-1, CEPSTRA)
    found = []
    for moved_by in (0.0, 4.0):
        (matrix, bias), *_ = fit_transforms([(spoken_by_the_model(model, moved_by), "0")], model)
        found.append((usual @ matrix.T + bias).mean(axis=0))
    assert np.allclose(found[1] - found[0], 4, atol=2)


def test_pocketsphinx_reads_it_and_what_changes_nothing_changes_nothing(
    model: AcousticModel, loaded: Language, recordings: list[Recording], tmp_path: Path
) -> None:
    text = as_text(fit_transforms([], model))
    assert is_transforms(text)
    (tmp_path / "mllr.txt").write_text(text)
    plain, same = Decoder(loaded), Decoder(loaded, mllr=str(tmp_path / "mllr.txt"))
    (tmp_path / "upside_down.txt").write_text(text.replace("1.000000", "-1.000000"))
    wrong = Decoder(loaded, mllr=str(tmp_path / "upside_down.txt"))
    clips = [r for r in recordings if r.kind == "command"][::9]

    def decoded(decoder: Decoder) -> list[str]:
        return [decoder.decode(r.samples(), mean_start(r.samples())) for r in clips]

    assert decoded(same) == decoded(plain)
    assert decoded(wrong) != decoded(plain)


@pytest.mark.parametrize("text", ["", "1\n3\n13", "nonsense", "nan " * 587])
def test_what_is_no_transform_is_seen(text: str) -> None:
    assert not is_transforms(text)
