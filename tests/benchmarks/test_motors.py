"""`benchmarks/motors.py` as it is called: a robot that hears `stop` above its own motors."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
import soundfile
from benchmark_programs import cells, printed
from recordings import FIXTURES

COMMANDS = FIXTURES / "commands"
VOICES = ("festival_slt", "flite_slt", "flite_rms", "flite_awb", "festival_ked", "festival_kal")


def hum(seconds: float) -> np.ndarray:
    """A gear, its overtones, and hiss: it goes on and changes all the time."""
    time = np.arange(int(seconds * 16000)) / 16000
    tones = sum(np.sin(2 * np.pi * 110 * n * time) / n for n in range(1, 30))
    hiss = np.random.default_rng(1).normal(0, 1, len(time))
    return 0.05 * (1 + 0.3 * np.sin(2 * np.pi * 1.7 * time)) * (tones + hiss)


@pytest.mark.slow
def test_stop_is_heard_in_time_above_the_robots_own_motors(tmp_path: Path) -> None:
    soundfile.write(tmp_path / "motors.flac", hum(20), 16000)
    said = [(voice, text) for voice in VOICES for text in ("stop", "turn left")]
    rows = [(COMMANDS / f"{v}__{t.replace(' ', '_')}.flac", t, v, "command", "us") for v, t in said]
    there = [row for row in rows if row[0].exists()]
    lines = ["path\ttext\tspeaker\tkind\tcondition", *("\t".join(map(str, row)) for row in there)]
    (tmp_path / "some.tsv").write_text("\n".join([*lines, ""]))
    lines = printed("motors", tmp_path / "some.tsv", "--noise", tmp_path / "motors.flac")
    rows_found = [each for each in cells(lines) if len(each) == 3]
    found = {name: (int(n), float(share.split()[0])) for name, n, share in rows_found}
    stops, in_time = found["`stop` in time"]
    assert stops >= 4
    assert in_time >= 0.8
    assert found["other commands in time"][0] == len(there) - stops
    assert found["halted before anything was said"] == (len(there), 0.0)
