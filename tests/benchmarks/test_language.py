"""`benchmarks/language.py` as it is called, with clips of espeak-ng."""

from __future__ import annotations

from pathlib import Path

import pytest
from benchmark_programs import printed

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
    rows = [line for line in printed("language", tmp_path) if line.startswith(("| es", "| fr"))]
    assert rows == [
        "| es | ana | 2 | 1.000 | 1.000 | 0 |  |",
        "| es | eva | 0 |  |  |  | 0 of 1 |",
        "| es | all | 2 | 1.000 | 1.000 | 0 | 0 of 1 |",
        "| fr | luc | 1 | 1.000 | 1.000 | 0 |  |",
        "| fr | all | 1 | 1.000 | 1.000 | 0 |  |",
    ]
