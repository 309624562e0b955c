"""What is heard is kept while the microphone is listened to."""

from __future__ import annotations

import shutil
import time
from pathlib import Path

import numpy as np
import pytest
from calls import in_process
from live_robot import live_robot, speak, warns
from programs import PATIENCE, wait_until
from recordings import FIXTURES, GO_BACK

from voz.apps.recordings.manifest import MANIFEST_NAME, read_manifest
from voz.apps.recordings.recorder import Recorder
from voz.audio import SAMPLE_RATE
from voz.errors import AudioError
from voz.events import Utterance

HEARD = Utterance(2, "stop", 0.9, True, 1, 2, "microphone")


def noise(seconds: float) -> np.ndarray:
    samples = np.random.default_rng(0).normal(0, 3000, int(seconds * SAMPLE_RATE))
    return samples.astype(np.int16)


def test_a_folder_that_cannot_be_made_is_one_warning(tmp_path: Path) -> None:
    (tmp_path / "file").write_text("no folder")
    said: list[str] = []
    with Recorder(tmp_path / "file", 1, said.append) as recorder:
        recorder._thread.join()
        assert recorder.note == ""
        for _ in range(100):
            recorder.mark(HEARD, 0)
            recorder.feed(noise(3))
    assert said[-1] == f"nothing more is recorded: {tmp_path}/file: cannot be written (File exists)"
    assert len(said) <= 2


def test_a_disk_that_goes_away_is_one_warning(tmp_path: Path) -> None:
    said: list[str] = []
    folder = tmp_path / "disk"
    with Recorder(folder, 1, said.append) as recorder:
        while not (folder / MANIFEST_NAME).exists():
            time.sleep(0.01)
        shutil.rmtree(folder)
        for _ in range(3):
            recorder.mark(HEARD, 0)
            recorder.feed(noise(3))
    assert said == [
        f"what is said is recorded in {folder}",
        f"nothing more is recorded: {folder}: cannot be written (No such file or directory)",
    ]


def test_what_was_kept_is_told_and_can_be_corrected_until_the_disk_fails(tmp_path: Path) -> None:
    folder = tmp_path / "mine"
    with Recorder(folder, 1, lambda _: None) as recorder:
        recorder.mark(HEARD, 0)
        recorder.feed(noise(3))
        wait_until(lambda: recorder.kept)
        start, file = recorder.kept.popleft()
        assert (start, folder / file) == (HEARD.start, next(folder.glob("*.flac")))
        recorder.correct(file, "go back", "command").result(PATIENCE)
        assert [clip.text for clip in read_manifest(folder / MANIFEST_NAME)] == ["go back"]
        with pytest.raises(AudioError, match="was removed"):
            recorder.correct("other.flac", "go back", "command").result(PATIENCE)
        shutil.rmtree(folder)
        with pytest.raises(FileNotFoundError):
            recorder.correct(file, "stop", "command").result(PATIENCE)
    with pytest.raises(AudioError, match="nothing is recorded any more"):
        recorder.correct(file, "stop", "command")


@pytest.mark.slow
def test_what_a_run_records_decodes_alike(pulse: dict[str, str], tmp_path: Path) -> None:
    folder = tmp_path / "mine"
    with live_robot(pulse, "--listening", "--record", str(folder)) as robot:
        robot.wait_for(warns(f"what is said is recorded in {folder}"))
        for name in ("commands/festival_slt__go_forward", "near_misses/festival_kal__turn"):
            since = len(robot.arrived)
            speak(pulse, FIXTURES / f"{name}.flac")
            robot.wait_for(lambda event: event["type"] == "utterance", since)
        robot.type("stop")  # makes no sound
        robot.wait_for(lambda event: event["type"] == "utterance" and event["source"] == "text")
        assert robot.end() == 143
        told = [event for event in robot.of("utterance") if event["source"] == "microphone"]
    clips = read_manifest(folder / MANIFEST_NAME)
    kinds = [clip.kind for clip in clips]
    assert kinds == ["command" if event["accepted"] else "near-miss" for event in told]
    decoded = in_process("decode", "--json", *(clip.path for clip in clips)).json
    assert [event["text"] for event in decoded] == [event["text"] for event in told]
    assert [event["accepted"] for event in decoded] == [event["accepted"] for event in told]


def test_recordings_are_not_recorded_again() -> None:
    result = in_process("run", "--wav", GO_BACK, "--record", "x")
    assert result.complaint == (
        "voz: --record keeps what a microphone hears: leave out --wav and --text"
    )
