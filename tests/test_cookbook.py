"""The recipes of docs/cookbook.md, as their reader follows them, without the hardware."""

from __future__ import annotations

import json
import os
import shlex
import shutil
import struct
import subprocess
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import soundfile
from calls import VOZ, in_process
from documents import Document, recipe
from live_robot import live_robot, speak
from programs import PATIENCE, free_port, wait_until
from pulseaudio import pactl
from recordings import ROOT
from synthesis import phrase

from voz.audio import SAMPLE_RATE

pytestmark = pytest.mark.slow


def robot_of(page: Document, folder: Path) -> dict[str, Any]:
    """Make the list and the settings of a recipe; returns how a program is started there."""
    (folder / "commands.txt").write_text("start speech\nstop\n" + page.blocks("text")[0])
    (folder / "voz.toml").write_text(page.blocks("toml")[0])
    here: dict[str, Any] = {"cwd": folder, "env": os.environ | {"PYTHONPATH": str(ROOT)}}
    assert in_process("build-lm", "commands.txt", "--out", "lm", **here).code == 0
    return here


@contextmanager
def broker(folder: Path) -> Iterator[tuple[list[str], Path]]:
    """A broker; gives the options by which it is reached, and where what it gets is written."""
    at, said = ["-p", str(free_port())], folder / "said"
    program = shutil.which("mosquitto", path=f"{os.environ['PATH']}:/usr/sbin")
    assert program, "tools/install.sh tests installs it"
    with subprocess.Popen([program, *at], stderr=subprocess.DEVNULL) as server:
        wait_until(
            lambda: subprocess.run(["mosquitto_pub", *at, "-t", "a", "-m", "b"]).returncode == 0
        )
        with (
            said.open("w") as file,
            subprocess.Popen(["mosquitto_sub", *at, "-t", "lamp/set"], stdout=file) as listener,
        ):
            greet = ["mosquitto_pub", *at, "-t", "lamp/set", "-m", "hello"]
            wait_until(lambda: subprocess.run(greet, check=True) and said.read_text())
            yield at, said
            listener.terminate()
        server.terminate()


def test_what_is_said_reaches_a_broker_of_mqtt(tmp_path: Path) -> None:
    here = robot_of(recipe("MQTT"), tmp_path)
    with broker(tmp_path) as (at, said):
        (tmp_path / "config").mkdir()
        (tmp_path / "config" / "mosquitto_pub").write_text(" ".join(at))
        here["env"]["XDG_CONFIG_HOME"] = str(tmp_path / "config")
        run = in_process("run", "--text", "-", input="start speech\nlight on\nlight off", **here)
        assert run.code == 0, run.err
        wait_until(lambda: said.read_text().replace("hello\n", "") == "ON\nOFF\n")


class Gamepad:
    """One that writes what Linux does when its cross and its buttons are pressed."""

    def __init__(self, path: Path) -> None:
        self._file = path.open("wb", buffering=0)

    def press(self, kind: int, number: int, value: int) -> None:
        self._file.write(struct.pack("IhBB", 0, value, kind, number))

    def unplug(self) -> None:
        self._file.close()


@pytest.mark.realtime
def test_a_gamepad_drives_beside_the_voice(pulse: dict[str, str], tmp_path: Path) -> None:
    line = recipe("A gamepad beside the voice").blocks("")[0]
    typing, _, running = line.partition(" | ")
    device, events = tmp_path / "js0", tmp_path / "events.jsonl"
    os.mkfifo(device)
    script = [sys.executable, str(ROOT / typing.split()[1]), str(device)]
    options = shlex.split(running.replace("ros2", "console"))[1:]
    options += ["--listening", "--no-sound", "--events", str(events)]

    def drives_at(linear: float) -> bool:
        lines = events.read_text().splitlines()[:-1] if events.exists() else []
        velocities = [e["linear"] for e in map(json.loads, lines) if e["type"] == "cmd_vel"]
        return velocities[-1:] == [linear]

    with (
        subprocess.Popen(script, stdout=subprocess.PIPE) as hand,
        subprocess.Popen(
            [*VOZ, *options], stdin=hand.stdout, env=pulse, stdout=subprocess.DEVNULL
        ) as robot,
    ):
        gamepad = Gamepad(device)
        wait_until(lambda: drives_at(0))
        gamepad.press(2 | 128, 7, 32767)  # how it stands at the start
        gamepad.press(2, 7, -32767)
        wait_until(lambda: drives_at(0.1))
        gamepad.press(2, 7, 0)
        wait_until(lambda: drives_at(0))
        soundfile.write(tmp_path / "back.wav", phrase("festival_slt", "go back"), SAMPLE_RATE)
        wait_until(lambda: speak(pulse, tmp_path / "back.wav") or drives_at(-0.1))
        gamepad.press(1, 0, 1)  # the button that stops
        wait_until(lambda: drives_at(0))
        gamepad.press(2, 7, -32767)
        wait_until(lambda: drives_at(0.1))
        gamepad.unplug()
        wait_until(lambda: drives_at(0))
        assert hand.wait(PATIENCE) == 0
        robot.terminate()
        assert robot.wait(PATIENCE) == 143


@pytest.mark.realtime
def test_a_headset_is_found_by_a_part_of_its_name_and_one_that_is_gone_stops_the_robot(
    own_pulse: tuple[dict[str, str], subprocess.Popen[bytes]], tmp_path: Path
) -> None:
    environment, _ = own_pulse

    connect = (
        "load-module module-remap-source master=mic.monitor "
        "source_name=bluez_input.AA_BB_CC_DD_EE_FF"
    )
    headset = pactl(environment, connect)
    lines = recipe("A Bluetooth headset").blocks("")[0].splitlines()
    (options,) = [line.removeprefix("voz run ") for line in lines if line.startswith("voz run ")]
    soundfile.write(tmp_path / "said.wav", phrase("festival_slt", "go forward"), SAMPLE_RATE)

    def is_obeyed() -> bool:
        said = len(robot.commands())
        speak(environment, tmp_path / "said.wav")
        return "go forward" in robot.commands()[said:]

    with live_robot(environment, *options.split(), "--listening") as robot:
        wait_until(is_obeyed)
        assert "bluez_input" in robot.words
        since = len(robot.arrived)
        pactl(environment, f"unload-module {headset}")
        robot.wait_for(lambda event: event["type"] == "warning", since)
        robot.wait_for(lambda event: event["type"] == "cmd_vel" and not event["linear"], since)
        assert "the microphone is gone" in robot.warnings(since)[0]
        pactl(environment, connect)
        wait_until(is_obeyed)


def said_to_two(folder: Path) -> Path:
    """A recording in which somebody speaks to two robots, and stops both."""
    said = {
        "hey robot": ("start speech", "go forward"),
        "computer": ("start speech", "go back"),
    }
    order = [(name, texts[n]) for n in (0, 1) for name, texts in said.items()]
    parts = [np.zeros(SAMPLE_RATE)]
    for name, text in order:
        parts += [phrase("festival_slt", name), np.zeros(SAMPLE_RATE // 3)]
        parts += [phrase("festival_slt", text), np.zeros(8 * SAMPLE_RATE)]
    parts += [phrase("festival_slt", "stop"), np.zeros(2 * SAMPLE_RATE)]
    sound = np.concatenate(parts)
    sound += np.random.default_rng(0).normal(0, 0.0005, len(sound))
    soundfile.write(folder / "said.wav", sound, SAMPLE_RATE)
    return folder / "said.wav"


def test_two_robots_obey_their_own_names_and_both_stop(tmp_path: Path) -> None:
    recording = said_to_two(tmp_path)
    obeyed = []
    for settings in recipe("Two robots").blocks("toml"):
        path = tmp_path / settings.partition("\n")[0].removeprefix("# ")
        path.write_text(settings)
        call = ("--config", path, "--wav", recording, "--no-sound", "--events", "-")
        events = in_process("run", *call).json
        obeyed.append([e["text"] for e in events if e["type"] == "utterance" and e["obeyed"]])
    assert obeyed == [
        ["hey robot", "start speech", "hey robot", "go forward", "stop"],
        ["computer", "start speech", "computer", "go back", "stop"],
    ]


def test_a_robot_at_a_fair_is_slow_and_stops_by_itself(tmp_path: Path) -> None:
    page = recipe("A demo at a fair")
    (tmp_path / "voz.toml").write_text(page.blocks("toml")[0])
    here: dict[str, Any] = {"cwd": tmp_path, "env": os.environ | {"PYTHONPATH": str(ROOT)}}
    typed = "\n".join(["start speech", "go forward", *["speed up"] * 5, *"-" * 50])
    run = in_process("run", "--text", "-", "--no-sound", "--events", "-", input=typed, **here)
    velocities = [event["linear"] for event in run.json if event["type"] == "cmd_vel"]
    assert max(velocities) == 0.2
    assert sum(map(bool, velocities[velocities.index(0.2) :])) < 40
    assert velocities[-1] == 0
    card = next(line for line in page.blocks("")[0].splitlines() if "--card" in line)
    assert in_process(*shlex.split(card)[1:], **here).code == 0
    assert "stop" in (tmp_path / "commands.html").read_text(encoding="utf-8")
