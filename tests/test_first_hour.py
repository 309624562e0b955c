"""A new user's first hour, step by step, on a real terminal and with a real microphone."""

from __future__ import annotations

import re
import shutil
import subprocess
import sys
import time
from collections.abc import Callable, Iterator
from contextlib import ExitStack
from pathlib import Path
from typing import Any

import pytest
import soundfile
from calls import in_process
from live_robot import speak
from live_terminal import COLOR, Terminal
from recordings import ROOT
from ros1.ros import eventually, running_ros
from synthesis import phrase

from voz.audio import SAMPLE_RATE

pytestmark = pytest.mark.slow

README = (ROOT / "README.md").read_text(encoding="utf-8")

OWN_COMMANDS = """\
start speech
stop
open gripper
open zipper
self destruct
yes
no
"""

OWN_SETTINGS = """\
lm = "lm"

[commands]
"open gripper" = { publish = "open", topic = "gripper" }
"open zipper" = { publish = "open", topic = "zipper" }
"self destruct" = { publish = true, topic = "destruct", confirm = "do you mean it?" }
"yes" = { answer = true }
"no" = { answer = false }
"""

Open = Callable[..., Terminal]


@pytest.fixture
def terminal(pulse: dict[str, str], tmp_path: Path) -> Iterator[Open]:
    """Opens terminals in the user's folder, with a microphone and a loudspeaker."""
    environment = pulse | {"XDG_DATA_HOME": str(tmp_path / "data")}
    with ExitStack() as parts:

        def opened(*arguments: str, **more: Any) -> Terminal:
            made = Terminal(environment, tmp_path, *arguments, **more)
            parts.callback(made.close)
            return made

        yield opened


@pytest.fixture
def say(pulse: dict[str, str], tmp_path: Path) -> Callable[[str], None]:
    """Says a text into the microphone."""

    def said(text: str) -> None:
        soundfile.write(tmp_path / "said.wav", phrase("festival_slt", text), SAMPLE_RATE)
        speak(pulse, tmp_path / "said.wav")

    return said


def say_until(
    terminal: Terminal,
    say: Callable[[str], None],
    text: str,
    happens: Callable[[dict[str, object]], bool],
) -> None:
    """Say a command until something comes of it: a busy machine loses some of the sound."""

    def tried() -> bool:
        say(text)
        return any(map(happens, terminal.events()))

    eventually(tried)


def is_event(kind: str, **fields: object) -> Callable[[dict[str, object]], bool]:
    return lambda event: event["type"] == kind and fields.items() <= event.items()


def end(terminal: Terminal) -> None:
    terminal.type("\x03")
    assert terminal.end() == 130
    assert "Traceback" not in terminal.look()


def own_list(folder: Path, *left_out: str) -> str:
    """Make a list of one's own; returns what `voz build-lm` says."""

    def without(text: str) -> str:
        return "".join(
            line for line in text.splitlines(True) if not line.strip('"').startswith(left_out)
        )

    (folder / "commands.txt").write_text(without(OWN_COMMANDS))
    (folder / "voz.toml").write_text(without(OWN_SETTINGS))
    made = in_process("build-lm", "commands.txt", "--out", "lm", cwd=folder)
    assert made.code == 0, made.err
    return made.out + made.err


def test_the_demo_says_what_it_does_and_what_it_wrote(tmp_path: Path) -> None:
    shutil.copytree(ROOT / "lm", tmp_path / "lm")
    (tmp_path / "audio_fixtures").symlink_to(ROOT / "audio_fixtures")
    (tmp_path / "tools").mkdir()
    shutil.copy(ROOT / "tools" / "demo.sh", tmp_path / "tools")
    (tmp_path / ".venv" / "bin").mkdir(parents=True)
    (tmp_path / ".venv" / "bin" / "voz").symlink_to(Path(sys.executable).with_name("voz"))
    done = subprocess.run(
        ["sh", tmp_path / "tools" / "demo.sh"],
        stdout=subprocess.PIPE,
        stderr=subprocess.STDOUT,
        text=True,
        timeout=120,
    )
    assert done.returncode == 0, done.stdout
    _, *steps = re.split(r"^== \d\. .*\n", done.stdout, flags=re.MULTILINE)
    assert len(steps) == 4
    assert all(step.strip() for step in steps)
    assert 'heard    "go forward"' in steps[1]
    for name in ("events.jsonl", "listening.wav", "stopped.wav"):
        assert (tmp_path / "demo" / name).stat().st_size > 0
    assert (tmp_path / "demo.png").stat().st_size > 0


def test_typed_commands_drive_and_a_space_or_escape_stops(terminal: Open) -> None:
    robot = terminal(command=("run", "--no-sound"))
    robot.wait_for_velocity(0.0)
    robot.type("start speech\r")
    robot.wait_for(is_event("reply"))
    robot.type("go forward\r")
    robot.wait_for_velocity(0.1)
    robot.type("speed up")
    robot.wait_to_see("speed up")
    robot.type("\r")
    robot.wait_for_velocity(0.15)
    robot.type(" ")
    robot.wait_for_velocity(0.0)
    robot.type("go back\r")
    robot.wait_for_velocity(-0.1)
    robot.type("\x1b")
    robot.wait_for_velocity(0.0)
    end(robot)


def test_the_robot_of_the_readme_prints_above_one_panel(terminal: Open, tmp_path: Path) -> None:
    code = next(block for block in re.findall(r"```python\n(.*?)```", README, re.DOTALL))
    (tmp_path / "wheels.py").write_text(code)
    robot = terminal("--robot", "wheels:Wheels")
    robot.wait_for_velocity(0.0)
    robot.type("go forward\r")
    robot.wait_to_see("forward 0.1 m/s")
    end(robot)
    rows = robot.rows()
    printed = [row for row in rows if row.startswith("forward")]
    assert "forward 0.1 m/s, to the left 0.0 rad/s" in printed
    assert sum(row.startswith("╭") for row in rows) <= 1


def test_a_list_of_ones_own_is_warned_about_obeyed_and_asks(
    terminal: Open, say: Callable[[str], None], tmp_path: Path
) -> None:
    told = own_list(tmp_path)
    assert re.search('"open gripper".*"open zipper"|"open zipper".*"open gripper"', told)
    robot = terminal()
    robot.wait_for_velocity(0.0)
    say_until(robot, say, "open gripper", is_event("publish", topic="gripper", value="open"))
    say_until(robot, say, "self destruct", is_event("reply", text="do you mean it?"))
    assert not any(map(is_event("publish", topic="destruct"), robot.events()))

    def confirmed() -> bool:
        say("yes")
        done = any(map(is_event("publish", topic="destruct", value=True), robot.events()))
        if not done:
            say("self destruct")  # the answer may have come when the question was forgotten
        return done

    eventually(confirmed)
    end(robot)


def test_calibration_says_what_it_heard_and_the_profile_is_used(
    terminal: Open, say: Callable[[str], None], tmp_path: Path
) -> None:
    own_list(tmp_path, "self destruct", "start speech")  # each takes its seconds
    calibration = terminal(command=("calibrate", "ana"))
    answered = 0
    while calibration.process.poll() is None:
        time.sleep(0.05)
        asked = re.findall(r"say(?: again)?: ([a-z ]+)\r", seen(calibration))
        if len(asked) > answered:
            answered = len(asked)
            is_first = answered == 1
            say("no" if is_first and asked[0] != "no" else "yes" if is_first else asked[-1])
    assert calibration.end() == 0
    assert f"say again: {asked[0]}" in seen(calibration)
    assert "heard: open gripper" in seen(calibration)
    robot = terminal("--profile", "ana")
    robot.wait_for_velocity(0.0)
    say_until(robot, say, "open zipper", is_event("publish", topic="zipper"))
    end(robot)


def seen(terminal: Terminal) -> str:
    return COLOR.sub("", terminal.look())


def test_ros_1_drives_by_the_microphone_and_logs_each_command_once(
    pulse: dict[str, str], say: Callable[[str], None], tmp_path: Path
) -> None:
    def speak_until(text: str, happens: Callable[[], bool]) -> None:
        eventually(lambda: say(text) or happens())

    with running_ros(tmp_path, **pulse) as ros:
        recognizer = ros.node("recognizer")
        control = ros.node("control_voz", "_sound:=none")
        client = ros.client("/cmd_vel", "/recognizer/output", "/recognizer/trouble")
        eventually(lambda: client.velocities() and {"data": ""} in client.of("/recognizer/trouble"))
        speak_until("start speech", lambda: "robot says" in control.text)
        speak_until("go forward", lambda: (0.1, 0) in client.velocities())
        published = client.of("/recognizer/output").count({"data": "go forward"})
        eventually(lambda: control.text.count("go forward") == published)
        assert "go forward" not in recognizer.text
