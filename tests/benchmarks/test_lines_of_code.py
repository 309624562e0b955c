"""`benchmarks/lines_of_code.py`: the table of docs/why.md, and the programs that run here."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path

import pytest
import soundfile
from benchmark_programs import printed
from recordings import ROOT, Recording

PROGRAMS = ROOT / "benchmarks" / "lines_of_code"


def test_the_documents_have_its_table_and_voz_needs_the_fewest_lines() -> None:
    lines = printed("lines_of_code")
    assert "\n".join(lines) in (ROOT / "docs" / "why.md").read_text(encoding="utf-8")
    _, _, *rows = lines
    assert len(rows) == 3
    for row in rows:
        voz, *others = (int(cell) for cell in row.strip("| ").split(" | ")[1:])
        assert voz <= min(others)


@pytest.mark.parametrize("library", ["voz", "pocketsphinx"])
def test_a_recording_is_understood(
    library: str, recordings: list[Recording], tmp_path: Path
) -> None:
    clip = next(each for each in recordings if each.text == "go forward")
    soundfile.write(tmp_path / "take.wav", clip.samples(), 16000, subtype="PCM_16")
    command = [sys.executable, PROGRAMS / f"file_{library}.py"]
    done = subprocess.run(command, cwd=tmp_path, capture_output=True, text=True, check=True)
    (heard,) = done.stdout.splitlines()
    assert heard == "go forward" if library == "voz" else heard
