"""`benchmarks/rooms.py` as it is called, on a room of a few seconds."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest
import soundfile
from benchmark_programs import cells, printed
from recordings import FIXTURES, Recording


@pytest.fixture
def rooms(tmp_path: Path) -> Path:
    """A stream of three commands, one of which nobody knows of, and one with nothing in it."""
    samples = np.random.default_rng(0).standard_normal(16 * 16000) * 5
    said: list[list[object]] = []
    for number, name in enumerate(["go_back", "turn_left", "stop", "hello_robot"]):
        folder = "near_misses" if name == "hello_robot" else "commands"
        clip = FIXTURES / folder / f"festival_slt__{name}.flac"
        spoken = Recording(clip, "", "", "").samples()
        start = (1 + 4 * number) * 16000
        samples[start : start + len(spoken)] += spoken
        text = None if name == "hello_robot" else name.replace("_", " ")
        said.append([start / 16000, (start + len(spoken)) / 16000, text, "us"])
    said[1][2:] = ["rotate left", "gb"]  # it will be taken for "turn left"
    del said[2]
    soundfile.write(tmp_path / "quiet.wav", samples.astype(np.int16), 16000)
    soundfile.write(tmp_path / "talk.wav", np.zeros(36000, np.int16), 16000)
    (tmp_path / "said.json").write_text(json.dumps({"quiet": said, "talk": []}))
    return tmp_path


@pytest.mark.slow
def test_a_line_for_each_stream(rooms: Path) -> None:
    header, _, quiet, talk = cells(printed("rooms", rooms, "--jobs", 1))
    assert header[:4] == ["stream", "right and accepted", "gb", "us"]
    assert quiet[:6] == ["quiet", "0.500", "0.000", "1.000", "1", "0 of 1"]
    assert quiet[6].startswith("1 in 0.00")
    assert talk == ["talk", "-", "-", "-", "-", "-", "0 in 0.0006 h (0 to 5902 per hour)"]
    assert len(printed("rooms", rooms, "talk", "--jobs", 1)) == 5
