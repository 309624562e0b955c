"""`benchmarks/microphone.py` as it is called, on two clips."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
import soundfile
from benchmark_programs import cells, printed
from recordings import GO_BACK


@pytest.mark.slow
def test_how_many_are_obeyed_under_each_verdict(tmp_path: Path) -> None:
    noise = np.random.default_rng(0).standard_normal(5 * 16000)
    soundfile.write(tmp_path / "tap.flac", 0.1 * noise, 16000)
    soundfile.write(tmp_path / "nothing.flac", np.zeros(16000), 16000)
    rows = [f"{GO_BACK}\tgo back\tslt\tcommand", "nothing.flac\tstop\tslt\tcommand"]
    rows += ["tap.flac\t\t\tnoise"]
    (tmp_path / "some.tsv").write_text("\n".join(["path\ttext\tspeaker\tkind", *rows, ""]))
    lines = printed("microphone", tmp_path / "some.tsv")
    assert lines[1] == "17 recordings of commands that are obeyed as they are"
    found = cells(lines)
    counts = {name: int(count) for name, count, _ in found if count.isdecimal()}
    assert sum(counts[name] for name in counts if name[0].isalpha()) == 17
    obeyed = {name: float(share) for name, count, share in found if count.isdecimal()}
    assert obeyed["fine"] > 0.8
    assert obeyed["fine"] > obeyed["TOO_QUIET"]
