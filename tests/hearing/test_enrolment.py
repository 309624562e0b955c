"""What a speaker is asked to say."""

from __future__ import annotations

import io
from collections.abc import Iterator
from pathlib import Path

import numpy as np
import pytest
from full_disk import full_disk
from recordings import GO_BACK
from rich.console import Console

from voz.audio import SAMPLE_RATE, Samples
from voz.audio.capture.files import read_blocks
from voz.errors import ConfigError
from voz.hearing.enrolment import PROMPTS, missing, prompts, read_kept, record
from voz.recognition.speaker.calibration import Said


def test_each_command_is_asked_for_and_some_twice_in_the_same_order_each_time() -> None:
    commands = [f"command {number}" for number in range(14)]
    asked = prompts(commands, "ana")
    assert asked == prompts(commands, "ana") != prompts(commands, "juan")
    assert (len(asked), set(asked)) == (PROMPTS, set(commands))
    assert len(set(prompts([str(n) for n in range(1000)], "ana"))) == PROMPTS


def test_what_is_recorded_is_not_asked_for_again() -> None:
    nothing = np.zeros(0, np.int16)
    assert missing(["a", "b", "a", "c"], [Said("a", nothing), Said("c", nothing)]) == ["b", "a"]


def say(asked: list[str], folder: Path) -> None:
    """Answer each prompt by the same recording."""
    record(asked, microphone(), folder, "ana", Console(file=io.StringIO()))


def microphone() -> Iterator[Samples]:
    while True:
        yield from read_blocks(GO_BACK)
        yield np.zeros(2 * SAMPLE_RATE, np.int16)


def test_a_recording_never_takes_the_place_of_another(tmp_path: Path) -> None:
    say(["start speech", "stop", "go forward"], tmp_path)
    first, *others = sorted(tmp_path.glob("*.flac"))
    before = {path: path.read_bytes() for path in others}
    manifest = tmp_path / "manifest.tsv"
    header, _, *rest = manifest.read_text().splitlines()
    manifest.write_text("\n".join([header, *rest]))  # as an editor may, without a last newline
    first.unlink()
    say(["go back"], tmp_path)
    texts = [said.text for said in read_kept(tmp_path, ["stop", "go forward", "go back"])]
    assert texts == ["stop", "go forward", "go back"]
    assert {path: path.read_bytes() for path in others} == before


def test_recordings_that_cannot_be_written_are_one_line_and_nothing(tmp_path: Path) -> None:
    say(["stop"], tmp_path)
    before = sorted(tmp_path.iterdir())
    with full_disk(1000), pytest.raises(ConfigError, match=r"cannot be written \(File too large\)"):
        say(["go back"], tmp_path)
    assert sorted(tmp_path.iterdir()) == before
