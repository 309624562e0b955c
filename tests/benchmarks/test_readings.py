"""`benchmarks/readings.py` as it is called, on recordings of one word."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest
import soundfile
from recordings import ROOT
from synthesis import VOICES, phrase, with_floor

from voz.recognition.second_ear import read_readings


@pytest.mark.slow
def test_yes_is_found_to_be_learned_by_heart_and_stop_is_not(tmp_path: Path) -> None:
    lines = ["path\ttext\tspeaker\tkind\n"]
    for voice in VOICES:
        for word in ("yes", "stop"):
            sound = with_floor(phrase(voice, word), np.random.default_rng(0))
            for number in range(2):  # two of each, so that either half of the voices has four
                file = f"{voice}_{word}_{number}.wav"
                soundfile.write(tmp_path / file, sound, 16000)
                lines.append(f"{file}\t{word}\t{voice}\tcommand\n")
    (tmp_path / "manifest.tsv").write_text("".join(lines))
    command = [sys.executable, str(ROOT / "benchmarks" / "readings.py")]
    done = subprocess.run(
        [*command, str(tmp_path / "manifest.tsv"), "--check"], capture_output=True, text=True
    )
    assert done.returncode == 1, done.stderr
    assert "has other readings" in done.stderr  # the file has more words than these two
    (found,) = [line for line in done.stdout.splitlines() if line.startswith("*")]
    assert found.startswith(f"* yes: {' '.join(read_readings()['yes'])} (")
