"""`benchmarks/batch.py` as it is called, on a few recordings."""

from __future__ import annotations

import pytest
from benchmark_programs import printed


@pytest.mark.slow
def test_it_prints_both_tables() -> None:
    lines = printed("batch", "--count", 4, "--rounds", 1, "--short", 5)
    rows = [line for line in lines if line.startswith("│")]
    ours = [row for row in rows if "voz" in row or "plain pocketsphinx" in row]
    assert len(ours) == 7
    assert not any("not installed" in row for row in ours)
    others = 3  # of which none need be here
    assert len(rows) == len(ours) + others + 1
