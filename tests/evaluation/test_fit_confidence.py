"""The model of the confidence is fitted on labelled recordings, and judged on other speakers."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from recordings import FIXTURES

from voz.errors import ConfigError
from voz.evaluation.fit_confidence import (
    Example,
    acceptance,
    collect,
    cross_validated,
    description,
    fit,
)
from voz.evaluation.manifest import read_manifest
from voz.evaluation.results import Clip
from voz.recognition.confidence import load_model, probability, save_model


def clip(number: int, kind: str = "command") -> Clip:
    return Clip(
        set="lab",
        file=f"{number}.wav",
        path=Path(f"{number}.wav"),
        text="stop",
        speaker=f"speaker {number % 10}",
        kind=kind,  # type: ignore[arg-type]
        condition="all",
    )


def examples(count: int = 600) -> list[Example]:
    """Right with the probability that a match of so much has: 1 / (1 + exp(-2 match))."""
    chance = np.random.default_rng(0)
    match = chance.normal(0, 1.5, count)
    right = chance.random(count) < 1 / (1 + np.exp(-2 * match))
    return [
        Example(clip(i), {"match": float(m), "nothing": float(chance.normal())}, 1.0, bool(r))
        for i, (m, r) in enumerate(zip(match, right, strict=True))
    ]


def test_it_finds_the_weights_that_the_examples_were_made_with() -> None:
    model = fit(examples(5000), ["made up"])
    assert model.fitted_on == ["made up"]
    assert model.weights["match"] == pytest.approx(2, abs=0.2)
    assert model.weights["nothing"] == pytest.approx(0, abs=0.1)


def test_the_share_of_near_misses_among_the_examples_does_not_matter() -> None:
    some = examples(5000)
    fewer = [e for i, e in enumerate(some) if e.right or i % 3 == 0]
    for match in (-2.0, 0.0, 1.0):
        values = {"match": match, "nothing": 0.0}
        one, other = (probability(fit(these, []), values) for these in (some, fewer))
        assert one == pytest.approx(other, abs=0.03)


def test_what_is_no_speech_is_not_fitted_on_and_never_likely() -> None:
    some = examples()
    noise = [
        Example(clip(i, "noise"), {"match": 9.0, "nothing": 0.0}, 0.0, False) for i in range(99)
    ]
    assert fit(some + noise, []) == fit(some, [])
    assert cross_validated(some + noise)[-99:] == [0.0] * 99


def test_acceptance_counts_by_set_kind_condition_and_outcome() -> None:
    some = [
        Example(clip(0), {}, 1.0, True),
        Example(clip(1), {}, 1.0, True),
        Example(clip(2, "near-miss"), {}, 1.0, False),
    ]
    assert acceptance(some, [0.9, 0.1, 0.6], threshold=0.5) == {
        "lab command all right": (0.5, 2),
        "lab near-miss all wrong": (1.0, 1),
    }


def test_examples_of_one_kind_alone_are_refused() -> None:
    with pytest.raises(ConfigError, match="both commands"):
        fit([e for e in examples() if e.right], [])


def test_the_fixtures_give_a_model_that_can_be_saved_and_read(tmp_path: Path) -> None:
    clips = read_manifest(FIXTURES / "manifest.tsv")[::6]
    found = [e for of_clip in collect(clips, None, 2) for e in of_clip]
    assert any(e.right for e in found)
    assert any(not e.right for e in found)
    assert all(set(e.values) == set(load_model().weights) for e in found)
    model = fit(found, [description(clips, "audio_fixtures")])
    assert "command" in model.fitted_on[0]
    save_model(model, tmp_path / "model.json")
    assert load_model(tmp_path / "model.json") == model


def test_a_model_that_cannot_be_written_is_one_clear_line(tmp_path: Path) -> None:
    with pytest.raises(ConfigError, match="cannot be written"):
        save_model(load_model(), tmp_path / "none" / "model.json")
