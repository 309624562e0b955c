"""`benchmarks/batch.py` as it is called, on a few recordings."""

from __future__ import annotations

import subprocess
import sys

import pytest
from recordings import ROOT


@pytest.mark.slow
def test_it_prints_both_tables() -> None:
    script = ROOT / "benchmarks" / "batch.py"
    given = ("--count", "4", "--rounds", "1", "--short", "5")
    done = subprocess.run([sys.executable, str(script), *given], capture_output=True, text=True)
    assert done.returncode == 0, done.stderr
    rows = [line for line in done.stdout.splitlines() if line.startswith("│")]
    ours = [row for row in rows if "voz" in row or "plain pocketsphinx" in row]
    assert len(ours) == 7
    assert not any("not installed" in row for row in ours)
    others = 3  # of which none need be here
    assert len(rows) == len(ours) + others + 1
