"""`benchmarks/recognition.py` as it is called, on a few clips."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
import soundfile
from benchmark_programs import cells, printed
from recordings import FIXTURES

COMMANDS = FIXTURES / "commands"
HEADER = "path\ttext\tspeaker\tkind\tcondition\n"
CLIPS = (
    f"{COMMANDS}/flite_slt__stop.flac\tstop\tslt\tcommand\tus\n"
    f"{COMMANDS}/flite_rms__go_back.flac\tgo back\trms\tcommand\tgb\n"
    f"{FIXTURES}/near_misses/flite_awb__start_again.flac\tstart again\tawb\tnear-miss\tgb\n"
)


@pytest.fixture
def dev(tmp_path: Path) -> Path:
    noise = np.random.default_rng(0).standard_normal(12 * 16000)
    soundfile.write(tmp_path / "dishes.flac", 0.1 * noise, 16000)
    path = tmp_path / "dev.tsv"
    path.write_text(f"{HEADER}{CLIPS}dishes.flac\t\t\tnoise\tnoise\n")
    return path


@pytest.fixture
def people(tmp_path: Path) -> Path:
    path = tmp_path / "people.tsv"
    talk = f"{FIXTURES}/formats/stereo_44100.wav\t\tme\ttalk\tus\n"
    path.write_text(HEADER + CLIPS + talk)
    return path


@pytest.mark.slow
def test_the_engines_stand_side_by_side(dev: Path, people: Path, tmp_path: Path) -> None:
    (tmp_path / "lists" / "mine").mkdir(parents=True)
    (tmp_path / "lists" / "mine" / "manifest.tsv").write_text(HEADER + CLIPS)
    lines = printed("recognition", dev, people, "--lists", tmp_path / "lists", "--jobs", 1)
    rows = {label: figures for label, *figures in cells(lines)}
    assert rows.pop("") == ["voz", "without-network", "pocketsphinx-phone-loop"]
    assert all(len(figures) == 3 for figures in rows.values())
    right = rows["commands right and accepted, American and British"]
    assert right == ["1.000 (1.00-1.00)"] * 3
    assert rows["mine: commands right and accepted"] == right
    assert rows["commands right and accepted, foreign accents"] == ["-"] * 3
    assert rows["false alarms in recorded noise"] == ["0 in 0.0033 h (0 to 1107 per hour)"] * 3
    assert rows["expected calibration error"][1:] == ["-"] * 2
    assert rows["false alarms in people's talk, us"][0].startswith("1 in 0.00")
