"""The node `soundplay` plays what programs made for sound_play ask for."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import soundfile
from loudspeaker import Recorder, is_silent, recording
from ros1.ros import Client, Program, Ros, eventually

from voz.ros1.own_messages import ALL, DEFINITION, ONCE, PLAY_FILE, SAY, START, STOP

TONE = 880.0
"""Hz, of the file that is played."""

BACKING_UP = 950.0
"""Hz, of the built-in sound 1."""


@pytest.fixture
def speaker(ros_with_sound: Ros) -> Iterator[Recorder]:
    with recording(ros_with_sound.environment) as recorder:
        yield recorder


@pytest.fixture
def playing(ros_with_sound: Ros, tmp_path: Path) -> tuple[Program, Client]:
    """The node, and a client that it hears."""
    packages = f"{ros_with_sound.environment['ROS_PACKAGE_PATH']}:{tmp_path / 'packages'}"
    node = ros_with_sound.node("soundplay", env={"ROS_PACKAGE_PATH": packages})
    client = ros_with_sound.client()

    def is_heard() -> bool:
        ask(client, 99, 77)
        return "77 is not a sound command" in node.text

    eventually(is_heard)
    return node, client


def ask(client: Client, sound: int, command: int, arg: str = "", arg2: str = "") -> None:
    data = {"sound": sound, "command": command, "volume": 1.0, "arg": arg, "arg2": arg2}
    kind = {"type": "sound_play/SoundRequest", "definition": DEFINITION}
    client.publish("/robotsound", data=data, **kind)


def share(heard: Any, frequency: float) -> float:
    """How much of the energy of what is heard is a tone."""
    power = np.abs(np.fft.rfft(heard)) ** 2
    middle = round(frequency * len(heard) / 16_000)
    return float(power[middle - 3 : middle + 4].sum() / max(power.sum(), 1e-12))


def falls_silent(speaker: Recorder) -> None:
    eventually(lambda: is_silent(speaker.pass_by(0.5)))


@pytest.mark.slow
def test_a_text_is_said_by_the_voice_that_is_named(
    playing: tuple[Program, Client], speaker: Recorder
) -> None:
    _, client = playing
    ask(client, SAY, ONCE, "good morning everybody", "voice_kal_diphone")
    eventually(lambda: not is_silent(speaker.pass_by(0.2)))
    falls_silent(speaker)
    ask(client, SAY, START, "again")
    eventually(lambda: not is_silent(speaker.pass_by(0.2)))
    assert not is_silent(speaker.pass_by(3))
    assert not is_silent(speaker.pass_by(2))
    ask(client, SAY, STOP, "again")
    falls_silent(speaker)


@pytest.mark.slow
def test_a_file_and_a_built_in_sound_are_played_until_they_are_stopped(
    playing: tuple[Program, Client], speaker: Recorder, tmp_path: Path
) -> None:
    _, client = playing
    tone = tmp_path / "tone.wav"
    soundfile.write(tone, 0.3 * np.sin(2 * np.pi * TONE * np.arange(8000) / 16_000), 16_000)
    ask(client, PLAY_FILE, START, str(tone))
    eventually(lambda: share(speaker.pass_by(0.5), TONE) > 0.5)
    ask(client, PLAY_FILE, STOP, str(tone))
    falls_silent(speaker)
    ask(client, 1, START)
    eventually(lambda: share(speaker.pass_by(0.7), BACKING_UP) > 0.3)
    ask(client, 1, STOP)
    falls_silent(speaker)
    ask(client, 1, START)
    ask(client, 2, START)
    eventually(lambda: not is_silent(speaker.pass_by(0.5)))
    ask(client, ALL, STOP)
    falls_silent(speaker)
    ask(client, PLAY_FILE, ONCE, str(tone))
    eventually(lambda: share(speaker.pass_by(0.5), TONE) > 0.5)
    falls_silent(speaker)


@pytest.mark.slow
def test_a_voice_may_have_its_encoding_and_a_file_its_package(
    playing: tuple[Program, Client], speaker: Recorder, tmp_path: Path
) -> None:
    node, client = playing
    ask(client, SAY, ONCE, "good morning everybody", "voice_kal_diphone:ISO-8859-15")
    eventually(lambda: not is_silent(speaker.pass_by(0.2)))
    falls_silent(speaker)
    (sounds := tmp_path / "packages" / "our_sounds" / "sounds").mkdir(parents=True)
    (sounds.parent / "package.xml").write_text("<package><name>our_sounds</name></package>")
    tone = 0.3 * np.sin(2 * np.pi * TONE * np.arange(8000) / 16_000)
    soundfile.write(sounds / "tone.wav", tone, 16_000)
    for name, package in (
        ("sounds/tone.wav", "our_sounds"),
        ("package://our_sounds/sounds/tone.wav", ""),
    ):
        ask(client, PLAY_FILE, START, name, package)
        eventually(lambda: share(speaker.pass_by(0.5), TONE) > 0.5)
        ask(client, PLAY_FILE, STOP, name, package)
        falls_silent(speaker)
    ask(client, PLAY_FILE, ONCE, "sounds/tone.wav", "nowhere")
    node.wait_for("there is no package 'nowhere'; source the workspace")


@pytest.mark.slow
def test_what_cannot_be_played_is_a_line_in_the_log(
    playing: tuple[Program, Client], tmp_path: Path
) -> None:
    node, client = playing
    touched = tmp_path / "touched"
    ask(client, PLAY_FILE, ONCE, "/none.wav")
    node.wait_for("/none.wav: ")
    ask(client, 42, ONCE)
    node.wait_for("there is no built-in sound 42")
    ask(client, SAY, ONCE, "hello", f'voice_(system "touch {touched}")')
    node.wait_for("is unknown; installed:")
    ask(client, ALL, START)
    node.wait_for("all sounds can only be stopped")
    assert not touched.exists()
    assert "Traceback" not in node.text
    assert node.process.poll() is None
