"""`benchmarks/mix_rooms.py` as it is called, on recordings of the fixtures and made noise."""

from __future__ import annotations

import json
from pathlib import Path
from zlib import crc32

import numpy as np
import pytest
import soundfile
from benchmark_programs import printed
from recordings import FIXTURES

RATE = 16_000
NAMES = [f"speaker-{number}" for number in range(99)]
SPEAKERS = {crc32(name.encode()) % 16 == 0: name for name in NAMES}
"""One from whom the network learns nothing, and one from whom it learns."""


@pytest.fixture
def manifest(tmp_path: Path) -> Path:
    """Two commands, a near-miss, talk, and the noises that the rooms are named by."""
    rng = np.random.default_rng(0)
    rows = [("path", "text", "speaker", "kind", "condition")]
    for name, held_back, kind in (("go_back", True, "command"), ("stop", False, "command")):
        clip = FIXTURES / "commands" / f"festival_slt__{name}.flac"
        rows.append((str(clip), name.replace("_", " "), SPEAKERS[held_back], kind, "us"))
    near_miss = FIXTURES / "near_misses" / "festival_slt__hello_robot.flac"
    rows.append((str(near_miss), "hello robot", SPEAKERS[True], "near-miss", "us"))
    for name in ("doing_the_dishes", "motor-0", "music-02", "talk"):
        soundfile.write(tmp_path / f"{name}.wav", 0.1 * rng.standard_normal(3 * RATE), RATE)
        kind = "talk" if name == "talk" else "noise"
        rows.append((f"{name}.wav", "", "somebody", kind, "us"))
    path = tmp_path / "manifest.tsv"
    path.write_text("".join("\t".join(row) + "\n" for row in rows))
    return path


def test_only_those_who_were_held_back_speak_in_sound_of_the_level_that_is_asked_for(
    manifest: Path, tmp_path: Path
) -> None:
    out = tmp_path / "rooms"
    lines = printed("mix_rooms", out, manifest, "--held-back")
    assert "1 commands and 1 near-misses" in "\n".join(lines)
    said = json.loads((out / "said.json").read_text())
    assert len(said) == 9
    assert {text for _, _, text, _ in said["kitchen-10"]} == {"go back", None}
    quiet, loud, louder = (
        soundfile.read(out / f"{name}.wav")[0] for name in ("quiet", "kitchen-15", "kitchen-10")
    )
    before = slice(0, int(min(start for start, *_ in said["quiet"]) * RATE))
    power = [np.mean(stream[before] ** 2) for stream in (quiet, loud, louder)]
    assert power[0] < 1e-3 * power[1]
    assert power[2] / power[1] == pytest.approx(10**0.5, rel=0.05)


def test_with_words_these_are_the_commands_and_what_has_none_of_them_is_a_near_miss(
    manifest: Path, tmp_path: Path
) -> None:
    out = tmp_path / "rooms"
    printed("mix_rooms", out, manifest, "--words")
    said = json.loads((out / "said.json").read_text())["motors-10"]
    assert [text for _, _, text, _ in said].count("stop") == 1
    assert len(said) == 2  # "go back" has a word of the list in it
    assert "eight" in (out / "list.txt").read_text().splitlines()
