"""What is heard is kept as a test set, cut out of a stream exactly, that the evaluation reads."""

from __future__ import annotations

import shutil
import tempfile
import time
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import soundfile
from calls import in_process
from full_disk import full_disk
from hypothesis import given
from hypothesis import strategies as st
from live_robot import live_robot, speak, warns
from programs import PATIENCE, wait_until
from recordings import FIXTURES, GO_BACK

from voz.apps.recordings.manifest import MANIFEST_NAME, read_manifest
from voz.apps.recordings.recorder import (
    BYTES_PER_GIGABYTE,
    EXCERPT_MARGIN,
    FOLDER_COLUMNS,
    Excerpt,
    RecentSound,
    Recorder,
    RecordingFolder,
)
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
        wait_until(lambda: recorder.note == "")
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


def test_recordings_are_not_recorded_again(voz: Any) -> None:
    result = voz("run", "--no-sound", "--wav", GO_BACK, "--record", "x")
    assert result.complaint == (
        "voz: --record keeps what a microphone hears: leave out --wav and --text"
    )


STREAM = np.arange(3 * SAMPLE_RATE, dtype=np.int16)


def heard(start: float, end: float) -> Utterance:
    return Utterance(end, "stop", 0.9, True, start, end, "microphone")


def blocks_of(stream: np.ndarray, cuts: list[int]) -> list[np.ndarray]:
    return np.split(stream, sorted(cuts))


@given(
    st.lists(st.integers(1, len(STREAM) - 1), max_size=20),
    st.integers(0, len(STREAM)),
    st.integers(0, len(STREAM)),
    st.integers(0, 20),
)
def test_the_sound_comes_with_its_margins_as_soon_as_it_is_there(
    cuts: list[int], one: int, other: int, marked: int
) -> None:
    start, end = sorted((one, other))
    tape = RecentSound()
    pieces: list[Excerpt] = []
    fed = 0
    for number, block in enumerate(blocks_of(STREAM, cuts)):
        if number == marked:
            tape.mark(start / SAMPLE_RATE, end / SAMPLE_RATE, heard(0, 1))
        fed += len(block)
        found = list(tape.feed(block))
        assert not found or fed >= end + EXCERPT_MARGIN
        pieces += found
    if marked > len(cuts):
        tape.mark(start / SAMPLE_RATE, end / SAMPLE_RATE, heard(0, 1))
    pieces += tape.finish()
    (piece,) = pieces
    np.testing.assert_array_equal(
        piece.samples, STREAM[max(0, start - EXCERPT_MARGIN) : end + EXCERPT_MARGIN]
    )


def test_the_memory_of_a_long_stream_is_bounded_and_what_is_kept_is_right() -> None:
    tape = RecentSound()
    second = np.zeros(SAMPLE_RATE, np.int16)
    for number in range(100):
        assert list(tape.feed(second + np.int16(number))) == []
    tape.mark(80, 90, heard(80, 90))
    for start in (0, 50):  # long forgotten
        tape.mark(start, start + 10, heard(start, start + 10))
    (piece,) = tape.finish()
    assert len(piece.samples) == 10 * SAMPLE_RATE + 2 * EXCERPT_MARGIN
    assert (piece.samples[0], piece.samples[-1]) == (79, 90)


def piece(text: str = "stop", accepted: bool = True, seconds: float = 0.1) -> Excerpt:
    samples = np.random.default_rng(0).normal(0, 3000, int(seconds * SAMPLE_RATE))
    utterance = Utterance(2, text, 0.9, accepted, 1, 2, "microphone")
    return Excerpt(utterance, samples.astype(np.int16))


def texts(path: Path) -> list[str]:
    return [clip.text for clip in read_manifest(path / MANIFEST_NAME)]


def test_accepted_utterances_are_commands_and_others_near_misses(tmp_path: Path) -> None:
    folder = RecordingFolder(tmp_path / "new" / "folder", BYTES_PER_GIGABYTE)
    folder.add(piece("go back"))
    folder.add(piece("stop", accepted=False))
    folder.add(piece("", accepted=False))
    clips = read_manifest(tmp_path / "new" / "folder" / MANIFEST_NAME)
    found = [(clip.kind, clip.text) for clip in clips]
    assert found == [("command", "go back"), ("near-miss", "stop"), ("near-miss", "")]
    samples, rate = soundfile.read(clips[0].path, dtype="int16")
    assert rate == SAMPLE_RATE
    np.testing.assert_array_equal(samples, piece().samples)
    line = (tmp_path / "new" / "folder" / MANIFEST_NAME).read_text().splitlines()[1]
    assert '{"type":"utterance","t":2' in line


def test_later_runs_add_to_earlier_ones_and_keep_what_was_corrected(tmp_path: Path) -> None:
    RecordingFolder(tmp_path, BYTES_PER_GIGABYTE).add(piece("go back"))
    manifest = tmp_path / MANIFEST_NAME
    manifest.write_text(manifest.read_text().replace("\tgo back\t", "\tgo forward\t"))
    RecordingFolder(tmp_path, BYTES_PER_GIGABYTE).add(piece("stop"))
    assert texts(tmp_path) == ["go forward", "stop"]


def test_a_line_that_was_cut_short_does_not_spoil_the_manifest(tmp_path: Path) -> None:
    RecordingFolder(tmp_path, BYTES_PER_GIGABYTE).add(piece("go back"))
    with (tmp_path / MANIFEST_NAME).open("a") as manifest:
        manifest.write("20261121-1000")
    RecordingFolder(tmp_path, BYTES_PER_GIGABYTE).add(piece("stop"))
    assert texts(tmp_path) == ["go back", "stop"]


@pytest.mark.parametrize("later", [False, True])
def test_a_users_line_without_an_end_is_kept(later: bool, tmp_path: Path) -> None:
    folder = RecordingFolder(tmp_path, BYTES_PER_GIGABYTE)
    manifest = tmp_path / MANIFEST_NAME
    manifest.write_text(manifest.read_text() + "mine.flac\tgo back\tme\tcommand\t")
    if later:
        folder = RecordingFolder(tmp_path, BYTES_PER_GIGABYTE)
    folder.add(piece("stop"))
    assert texts(tmp_path) == ["go back", "stop"]


def test_a_manifest_that_was_emptied_is_begun_anew(tmp_path: Path) -> None:
    (tmp_path / MANIFEST_NAME).touch()
    RecordingFolder(tmp_path, BYTES_PER_GIGABYTE).add(piece("stop"))
    assert texts(tmp_path) == ["stop"]


def test_a_full_disk_leaves_what_was_recorded(tmp_path: Path) -> None:
    folder = RecordingFolder(tmp_path, BYTES_PER_GIGABYTE)
    folder.add(piece("stop"))
    before = {path: path.read_bytes() for path in tmp_path.iterdir()}
    with full_disk(1000), pytest.raises(OSError, match="File too large"):
        folder.add(piece("go back"))
    assert {path: path.read_bytes() for path in tmp_path.iterdir()} == before


def test_another_manifest_is_refused_and_stays(tmp_path: Path) -> None:
    shutil.copy(FIXTURES / "manifest.tsv", tmp_path)
    before = (tmp_path / MANIFEST_NAME).read_text()
    with pytest.raises(
        AudioError, match=r"manifest\.tsv: is not a manifest of recordings; name another"
    ):
        RecordingFolder(tmp_path, BYTES_PER_GIGABYTE)
    assert (tmp_path / MANIFEST_NAME).read_text() == before


@given(
    st.lists(st.floats(0.01, 0.3), min_size=1, max_size=15),
    st.integers(1_000, 30_000),
    st.integers(0, 15),
)
def test_whatever_is_recorded_the_limit_holds_and_the_oldest_goes(
    lengths: list[float], limit: int, restart: int
) -> None:
    with tempfile.TemporaryDirectory() as name:
        path = Path(name)
        folder = RecordingFolder(path, limit)
        for number, seconds in enumerate(lengths):
            if number == restart:
                folder = RecordingFolder(path, limit)
            folder.add(piece(f"command {number}", seconds=seconds))
            files = list(path.glob("*.flac"))
            assert sum(file.stat().st_size for file in files) <= limit
            rows = [line.split("\t") for line in (path / MANIFEST_NAME).read_text().splitlines()]
            assert tuple(rows[0]) == FOLDER_COLUMNS
            assert {row[0] for row in rows[1:]} == {file.name for file in files}
            kept = [row[1] for row in rows[1:]]
            first = number + 1 - len(kept)
            assert kept == [f"command {n}" for n in range(first, number + 1)]


def test_a_users_own_recordings_are_not_removed(tmp_path: Path) -> None:
    RecordingFolder(tmp_path, BYTES_PER_GIGABYTE)
    shutil.copy(GO_BACK, tmp_path / "mine.flac")
    with (tmp_path / MANIFEST_NAME).open("a") as manifest:
        manifest.write("mine.flac\tgo back\tme\tcommand\t\n")
    folder = RecordingFolder(tmp_path, 10_000)
    for _ in range(5):
        folder.add(piece("stop", seconds=0.2))
    assert texts(tmp_path)[0] == "go back"
    assert (tmp_path / "mine.flac").exists()
    assert len(texts(tmp_path)) < 6


def test_what_was_really_said_is_written_and_all_else_stays(tmp_path: Path) -> None:
    folder = RecordingFolder(tmp_path, BYTES_PER_GIGABYTE)
    names = [folder.add(piece(text)) for text in ("go back", "stop", "fold arm")]
    manifest = tmp_path / MANIFEST_NAME
    manifest.write_text(manifest.read_text().replace("\tuser\t", "\tana\t"))
    before = manifest.read_text().splitlines()
    folder.correct(names[1], "", "near-miss")
    folder.correct(names[1], "slow down", "command")
    after = manifest.read_text().splitlines()
    assert after[2] == before[2].replace("\tstop\tana\t", "\tslow down\tana\t")
    assert [*after[:2], *after[3:]] == [*before[:2], *before[3:]]


def test_of_a_recording_that_went_for_others_nothing_can_be_said(tmp_path: Path) -> None:
    folder = RecordingFolder(tmp_path, 10_000)
    first, *_ = [folder.add(piece(seconds=0.2)) for _ in range(5)]
    before = (tmp_path / MANIFEST_NAME).read_text()
    with pytest.raises(AudioError, match="was removed; mark another one"):
        folder.correct(first, "stop", "command")
    assert (tmp_path / MANIFEST_NAME).read_text() == before
