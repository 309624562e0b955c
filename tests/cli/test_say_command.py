"""`voz say` and `voz sound`: what is heard, and what is told if it cannot be."""

from __future__ import annotations

import os
import signal
import subprocess
from pathlib import Path
from typing import Any

import pytest
import soundfile
from calls import VOZ, in_process
from loudspeaker import at_16_khz, best, is_silent, likeness, recording

from voz.audio.capture.sound_files import read_sound
from voz.audio.playback.playing_sound import PLAYBACK_RATE
from voz.speech.builtin_sounds import BuiltinSound, synthesize_sound

NO_LOUDSPEAKER = "there is no loudspeaker; connect one"


@pytest.fixture
def no_sound(tmp_path: Path) -> dict[str, str]:
    (tmp_path / "alsa.conf").write_text("pcm.default { type hw card 99 }")
    return os.environ | {"ALSA_CONFIG_PATH": str(tmp_path / "alsa.conf")}


def test_say_writes_a_wav(voz: Any, tmp_path: Path) -> None:
    result = voz("say", "hello robot", "--out", tmp_path / "hello.wav")
    assert result.code == 0
    assert result.err == f"written: {tmp_path / 'hello.wav'}, said by kal_diphone\n"
    assert soundfile.info(tmp_path / "hello.wav").duration > 0.4


def test_say_lists_the_voices_that_are_installed(voz: Any) -> None:
    assert "kal_diphone" in voz("say", "--list-voices").out.splitlines()


@pytest.mark.slow
def test_say_is_heard(pulse: dict[str, str]) -> None:
    with recording(pulse) as recorder:
        result = in_process("say", "hello", env=pulse)
        recorder.pass_by(0.2)
        assert (result.code, result.out, result.err) == (0, "", "")
        assert not is_silent(recorder.heard())


def test_sound_lists_the_built_in_sounds(voz: Any) -> None:
    assert voz("sound", "--list").out.splitlines() == [
        "backing-up",
        "needs-unplugging",
        "needs-plugging",
        "needs-unplugging-badly",
        "needs-plugging-badly",
    ]


@pytest.mark.realtime
@pytest.mark.slow
def test_a_built_in_sound_and_a_file_are_heard(pulse: dict[str, str], tmp_path: Path) -> None:
    wave = synthesize_sound(BuiltinSound.NEEDS_PLUGGING_BADLY)
    soundfile.write(tmp_path / "own.ogg", wave, PLAYBACK_RATE)

    with recording(pulse) as recorder:

        def alike(name: object) -> float:
            before = len(recorder.heard())
            assert in_process("sound", name, "--volume", 0.5, env=pulse).code == 0
            recorder.pass_by(0.2)
            return likeness(at_16_khz(wave), recorder.heard()[before:])

        assert best(lambda: alike("needs-plugging-badly"), 0.95) > 0.95
        assert best(lambda: alike(tmp_path / "own.ogg"), 0.95) > 0.95
    assert len(read_sound(tmp_path / "own.ogg", PLAYBACK_RATE)) == len(wave)


@pytest.mark.realtime
@pytest.mark.slow
def test_a_sound_that_repeats_ends_by_ctrl_c(pulse: dict[str, str]) -> None:
    command = [*VOZ, "sound", "backing-up", "--repeat"]
    with recording(pulse) as recorder, subprocess.Popen(command, env=pulse) as program:
        while is_silent(recorder.pass_by(0.2)):
            assert program.poll() is None
        assert not is_silent(recorder.pass_by(1))
        assert not is_silent(recorder.pass_by(1))
        program.send_signal(signal.SIGINT)
        assert program.wait(timeout=20) == 128 + signal.SIGINT
        recorder.pass_by(0.2)
        assert is_silent(recorder.pass_by(1))


@pytest.mark.parametrize(
    ("arguments", "complaint"),
    [
        (["sound"], "nothing to play"),
        (["sound", "forward-going"], "forward-going: is no file and no built-in sound; see `voz"),
        (["sound", "audio_fixtures"], "audio_fixtures: is a folder"),
        (["sound", "README.md"], "README.md: is no recording that can be read"),
        (["sound", "backing-up", "--volume", 2], "--volume"),
        (["sound", "backing-up", "--volume", "nan"], "'--volume': nan is no number"),
    ],
)
def test_a_sound_that_cannot_be_is_one_line(
    arguments: list[object], complaint: str, voz: Any
) -> None:
    assert complaint in voz(*arguments).complaint


@pytest.mark.parametrize("arguments", [["say", "hello"], ["sound", "backing-up"]])
def test_without_a_loudspeaker_it_is_an_error(
    arguments: list[str], no_sound: dict[str, str]
) -> None:
    assert in_process(*arguments, env=no_sound).complaint == f"voz: {NO_LOUDSPEAKER}"


def test_a_sound_that_repeats_waits_for_a_loudspeaker(no_sound: dict[str, str]) -> None:
    command = [*VOZ, "sound", "backing-up", "--repeat"]
    with subprocess.Popen(command, env=no_sound, stderr=subprocess.PIPE, text=True) as program:
        assert program.stderr is not None
        assert program.stderr.readline() == f"warning: {NO_LOUDSPEAKER}\n"
        program.send_signal(signal.SIGTERM)
        assert program.wait(timeout=20) == 128 + signal.SIGTERM
        assert program.stderr.read() == ""
