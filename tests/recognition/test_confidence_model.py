"""The file of a confidence's models: what is written is read, and nothing else is used."""

from __future__ import annotations

from pathlib import Path

import pytest
from msgspec.structs import replace

from voz.errors import ConfigError
from voz.recognition.confidence_model import load_models, save_models, with_log_odds


def test_what_was_written_is_read(tmp_path: Path) -> None:
    models = load_models()
    changed = replace(models, one_ear=with_log_odds(models.one_ear, 1.5))
    save_models(changed, tmp_path / "mine.json")
    assert load_models(str(tmp_path / "mine.json")) == changed
    assert changed.one_ear.intercept == models.one_ear.intercept + 1.5


def test_a_feature_of_another_voz_is_refused(tmp_path: Path) -> None:
    models = load_models()
    strange = replace(models.two_ears, weights={**models.two_ears.weights, "luck": 1.0})
    save_models(replace(models, two_ears=strange), tmp_path / "mine.json")
    with pytest.raises(ConfigError, match=r'"luck" is no feature of this voz\); name what'):
        load_models(str(tmp_path / "mine.json"))


def test_a_model_fitted_before_there_was_one_score_is_refused(tmp_path: Path) -> None:
    models = load_models()
    older = replace(models.two_ears, weights={"worst word": 0.7, "second fit": 1.8})
    save_models(replace(models, two_ears=older), tmp_path / "mine.json")
    with pytest.raises(ConfigError, match=r'"second fit" is no feature of this voz'):
        load_models(str(tmp_path / "mine.json"))


@pytest.mark.parametrize("text", ["", "{}", '{"one_ear": 3}', "[1,2]", "\x00"])
def test_what_is_no_such_file_is_one_line(text: str, tmp_path: Path) -> None:
    (tmp_path / "mine.json").write_text(text)
    with pytest.raises(ConfigError, match="name what `voz fit-confidence` wrote"):
        load_models(str(tmp_path / "mine.json"))


def test_a_model_that_cannot_be_written_is_one_clear_line(tmp_path: Path) -> None:
    with pytest.raises(ConfigError, match="cannot be written"):
        save_models(load_models(), tmp_path / "none" / "model.json")
