"""What a speaker is asked to say."""

from __future__ import annotations

import io
import itertools
from collections.abc import Iterator, Sequence
from pathlib import Path

import numpy as np
import pytest
from full_disk import full_disk
from recordings import FIXTURES, GO_BACK
from rich.console import Console

from voz.api.recognizer import Recognizer
from voz.apps.recordings.calibration import Said
from voz.apps.recordings.enrollment import (
    PROMPT_COUNT,
    check_recording,
    choose_prompts,
    missing_prompts,
    read_saved_recordings,
    record_prompts,
)
from voz.audio import SAMPLE_RATE, Samples
from voz.audio.sound_files import read_blocks
from voz.errors import ConfigError


def test_each_command_is_asked_for_and_some_twice_in_the_same_order_each_time() -> None:
    commands = [f"command {number}" for number in range(14)]
    asked = choose_prompts(commands, "ana")
    assert asked == choose_prompts(commands, "ana") != choose_prompts(commands, "juan")
    assert (len(asked), set(asked)) == (PROMPT_COUNT, set(commands))
    assert len(set(choose_prompts([str(n) for n in range(1000)], "ana"))) == PROMPT_COUNT


def test_what_is_recorded_is_not_asked_for_again() -> None:
    nothing = np.zeros(0, np.int16)
    assert missing_prompts(["a", "b", "a", "c"], [Said("a", nothing), Said("c", nothing)]) == [
        "b",
        "a",
    ]


def say(asked: list[str], folder: Path, recognizer: Recognizer, *clips: Path) -> list[str]:
    """Answer by recordings, one after the other and again; gives the lines that are shown."""
    shown = io.StringIO()
    blocks = microphone(clips or [GO_BACK])
    console = Console(file=shown, width=200)
    record_prompts(asked, blocks, recognizer, folder=folder, name="ana", console=console)
    return [" ".join(line.split()) for line in shown.getvalue().splitlines()]


def microphone(clips: Sequence[Path]) -> Iterator[Samples]:
    for clip in itertools.cycle(clips):
        yield from read_blocks(clip)
        yield np.zeros(2 * SAMPLE_RATE, np.int16)


def test_what_is_heard_is_shown_and_what_is_heard_wrongly_is_asked_for_once_more(
    tmp_path: Path, recognizer: Recognizer
) -> None:
    speech = [GO_BACK.with_name(f"festival_slt__{n}_speech.flac") for n in ("start", "stop")]
    other = FIXTURES / "near_misses" / "espeak_us__speed_limit.flac"
    said = [GO_BACK, other, GO_BACK, *speech]
    assert say(["go back", "go back", "start speech"], tmp_path, recognizer, *said) == [
        "1 of 3 say: go back",
        "heard: go back",
        "2 of 3 say: go back",
        "heard: speed up (unsure); say again: go back",
        "heard: go back",
        "3 of 3 say: start speech",
        "heard: start speech",
    ]
    assert len(list(tmp_path.glob("*.flac"))) == 3
    assert say(["go back"], tmp_path / "other", recognizer, *speech) == [
        "1 of 1 say: go back",
        "heard: start speech; say again: go back",
        "heard: stop speech; kept as it is",
    ]
    (kept,) = read_saved_recordings(tmp_path / "other", ["go back"])
    assert check_recording("go back", kept.samples, recognizer) == (False, "stop speech")


def test_a_recording_never_takes_the_place_of_another(
    tmp_path: Path, recognizer: Recognizer
) -> None:
    say(["start speech", "stop", "go forward"], tmp_path, recognizer)
    first, *others = sorted(tmp_path.glob("*.flac"))
    before = {path: path.read_bytes() for path in others}
    manifest = tmp_path / "manifest.tsv"
    header, _, *rest = manifest.read_text().splitlines()
    manifest.write_text("\n".join([header, *rest]))  # as an editor may, without a last newline
    first.unlink()
    say(["go back"], tmp_path, recognizer)
    texts = [
        said.text for said in read_saved_recordings(tmp_path, ["stop", "go forward", "go back"])
    ]
    assert texts == ["stop", "go forward", "go back"]
    assert {path: path.read_bytes() for path in others} == before


def test_recordings_that_cannot_be_written_are_one_line_and_nothing(
    tmp_path: Path, recognizer: Recognizer
) -> None:
    say(["stop"], tmp_path, recognizer)
    before = sorted(tmp_path.iterdir())
    with full_disk(1000), pytest.raises(ConfigError, match=r"cannot be written \(File too large\)"):
        say(["go back"], tmp_path, recognizer)
    assert sorted(tmp_path.iterdir()) == before
