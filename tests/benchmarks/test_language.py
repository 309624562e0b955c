"""`benchmarks/language.py` as it is called, with clips of espeak-ng."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path

import pytest
from recordings import ROOT

from voz.speech.synthesis import render

SAID = (
    ("es", "ana", "command", "gira a la derecha"),
    ("es", "ana", "command", "avanza"),
    ("es", "eva", "near-miss", "buenos días a todos"),
    ("fr", "luc", "command", "tourne à gauche"),
)


@pytest.mark.slow
def test_each_speaker_of_each_language_gets_a_row(tmp_path: Path) -> None:
    lines = ["path\ttext\tspeaker\tkind\tlanguage"]
    for number, (language, speaker, kind, text) in enumerate(SAID):
        render(text, f"espeak-ng:{language}", tmp_path / f"{number}.wav")
        lines.append(f"{number}.wav\t{text}\t{speaker}\t{kind}\t{language}")
    (tmp_path / "manifest.tsv").write_text("\n".join(lines), encoding="utf-8")
    script = ROOT / "benchmarks" / "language.py"
    done = subprocess.run([sys.executable, script, tmp_path], capture_output=True, text=True)
    assert done.returncode == 0, done.stderr
    rows = [line for line in done.stdout.splitlines() if line.startswith(("| es", "| fr"))]
    assert rows == [
        "| es | ana | 2 | 1.000 | 1.000 | 0 |  |",
        "| es | eva | 0 |  |  |  | 0 of 1 |",
        "| es | all | 2 | 1.000 | 1.000 | 0 | 0 of 1 |",
        "| fr | luc | 1 | 1.000 | 1.000 | 0 |  |",
        "| fr | all | 1 | 1.000 | 1.000 | 0 |  |",
    ]


def test_a_manifest_without_languages_is_refused(tmp_path: Path) -> None:
    (tmp_path / "manifest.tsv").write_text("path\ttext\na.wav\ta\n")
    script = ROOT / "benchmarks" / "language.py"
    done = subprocess.run([sys.executable, script, tmp_path], capture_output=True, text=True)
    assert done.returncode == 2
    assert "has no column kind" in done.stderr
