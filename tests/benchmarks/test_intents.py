"""`benchmarks/intents.py` as it is called, on a benchmark of two clips."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest
import soundfile
import soxr
from benchmark_programs import cells, printed

from voz.speech.synthesis import render


@pytest.fixture
def benchmark(tmp_path: Path) -> Path:
    """Two orders, of which one has another label, and white noise."""
    data = tmp_path / "data"
    for folder in ("speech/clean", "label", "noise"):
        (data / folder).mkdir(parents=True)
    orders = {
        "one.wav": ("can I have a large mocha with soy milk", {"size": "large"}),
        "two.wav": ("make me a double shot latte with cream", {"size": "small"}),
    }
    labels = {}
    for name, (text, slots) in orders.items():
        render(text, "cmu_us_slt_arctic_hts", tmp_path / name)
        sound, rate = soundfile.read(tmp_path / name)
        soundfile.write(data / "speech/clean" / name, soxr.resample(sound, rate, 16000), 16000)
        labels[name] = {"intent": "orderDrink", "slots": slots}
    (data / "label" / "label.json").write_text(json.dumps(labels))
    noise = np.random.default_rng(0).normal(0, 0.1, 20 * 16000)
    soundfile.write(data / "noise" / "white.wav", noise, 16000)
    return tmp_path


@pytest.mark.slow
def test_what_is_accepted_and_what_is_wrong_stand_beside_what_is_published(
    benchmark: Path,
) -> None:
    lines = printed("intents", benchmark, "--level", 24, "--jobs", 1, "--all")
    _, none, white = cells(lines)
    # The first has all slots of its label and two more, so it is accepted and yet another order.
    assert none[:7] == ["none", "-", "0.500", "-", "-", "1.000", "0.000"]
    assert white[:5] == ["white", "24", "0.500", "0.99", "0.96"]
    assert "two.wav 0: small => make me a double shot latte with cream (obeyed" in "\n".join(lines)


@pytest.mark.slow
def test_orders_behind_a_name_count_and_the_name_itself_does_not(benchmark: Path) -> None:
    named = [*("--name", "hey robot"), *("--noise", "none"), *("--jobs", 1)]
    lines = printed("intents", benchmark, *named, "--all")
    _, none = cells(lines)
    assert none[:7] == ["none", "-", "0.500", "-", "-", "1.000", "0.000"]
    assert not any("hey robot" in line for line in lines)
