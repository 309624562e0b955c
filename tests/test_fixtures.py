"""The recordings of audio_fixtures/ are what their manifest says, and what other tests rely on."""

import os
import subprocess
import sys
from pathlib import Path
from typing import NamedTuple

import numpy as np
import pytest
import soundfile

from voz.apps.recordings.manifest import parse_lines

ROOT = Path(__file__).parent.parent
FOLDER = ROOT / "audio_fixtures"
COMMANDS = (ROOT / "lm" / "comandos_voz.txt").read_text().split("\n")[:-1]
CLIPS = ("command", "near-miss")
KITCHEN = "long/kitchen.wav"


class Recording(NamedTuple):
    file: str
    text: str
    voice: str
    kind: str

    @property
    def path(self):
        return FOLDER / self.file


def manifest():
    (_, header), *rows = parse_lines((FOLDER / "manifest.tsv").read_text())
    assert header == list(Recording._fields)
    return [Recording(*row.fields) for row in rows]


def of_kind(*kinds):
    return [recording for recording in manifest() if recording.kind in kinds]


def level(samples):
    """Root mean square in dB below full scale."""
    return 20 * np.log10(np.sqrt(np.mean(samples**2)))


def edges(recording, seconds=0.25):
    samples, rate = soundfile.read(recording.path, always_2d=True)
    length = round(seconds * rate)
    return samples[:length], samples[-length:]


def test_every_row_has_its_file_and_every_file_its_row():
    listed = [recording.file for recording in manifest()]
    there = {
        path.relative_to(FOLDER).as_posix()
        for path in FOLDER.rglob("*")
        if path.is_file() and path.suffix not in (".tsv", ".txt")
    }
    assert set(listed) == there
    assert len(listed) == len(there)


def test_every_voice_speaks_every_command_once():
    spoken = [(recording.voice, recording.text) for recording in of_kind("command")]
    voices = {voice for voice, _ in spoken}
    assert sorted(spoken) == sorted((voice, text) for voice in voices for text in COMMANDS)


def test_there_are_sixty_near_misses_and_none_is_a_command():
    texts = [recording.text for recording in of_kind("near-miss")]
    assert len(set(texts)) == len(texts) >= 60
    assert set(texts).isdisjoint(COMMANDS)


@pytest.mark.parametrize(
    ("which", "format_", "rate", "channels", "shortest", "longest"),
    [
        ({*CLIPS}, "FLAC", 16_000, 1, 0.9, 3),
        ({"long"}, "WAV", 16_000, 1, 20, 40),
        ({"formats/stereo_44100.wav"}, "WAV", 44_100, 2, 0.9, 3),
        ({"formats/mono_8000.wav"}, "WAV", 8000, 1, 0.9, 3),
    ],
)
def test_each_recording_has_the_form_of_its_kind(which, format_, rate, channels, shortest, longest):
    found = [each for each in manifest() if {each.kind, each.file} & which]
    assert found
    for recording in found:
        info = soundfile.info(recording.path)
        assert (info.format, info.subtype) == (format_, "PCM_16"), recording
        assert (info.samplerate, info.channels) == (rate, channels), recording
        assert shortest < info.duration < longest, recording


def test_long_recordings_are_two_of_several_commands():
    recordings = of_kind("long")
    assert [recording.file for recording in recordings] == [KITCHEN, "long/session.wav"]
    for recording in recordings:
        texts = recording.text.split(" | ")
        assert len(texts) > 5
        assert set(texts) <= set(COMMANDS)


def test_every_recording_is_loud_and_none_is_clipped():
    for recording in manifest():
        peak = np.abs(soundfile.read(recording.path)[0]).max()
        assert -6.5 < 20 * np.log10(peak) < -2.5, recording


def test_recordings_begin_and_end_in_a_quiet_room_without_digital_silence():
    for recording in manifest():
        if recording.file != KITCHEN:
            for edge in edges(recording):
                assert -95 < level(edge) < -60, recording


def test_the_kitchen_is_noisy_before_and_after_the_speech():
    samples, _ = soundfile.read(FOLDER / KITCHEN)
    [recording] = [each for each in manifest() if each.file == KITCHEN]
    for edge in edges(recording, seconds=0.65):
        assert -50 < level(edge) < level(samples) - 6


def test_a_missing_engine_is_one_line_that_says_what_to_install(tmp_path):
    run = subprocess.run(
        [sys.executable, ROOT / "tools" / "make_fixtures.py", "--output", tmp_path],
        env={**os.environ, "PATH": str(tmp_path)},
        capture_output=True,
        text=True,
    )
    assert run.returncode == 2
    [line] = [line for line in run.stderr.splitlines() if "apt-get" in line]
    assert "install festival festvox-kallpc16k festvox-kdlpc16k" in line
    assert "Traceback" not in run.stderr
    assert not list(tmp_path.iterdir())
