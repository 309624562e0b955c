"""A robot that is driven by a microphone, or by utterances, in a program of one's own."""

from __future__ import annotations

import asyncio
import subprocess
import sys
import time
from collections.abc import Callable, Iterator
from contextlib import suppress
from threading import Thread

import pytest
from programs import PATIENCE
from recordings import FIXTURES

import voz

SAID = FIXTURES / "commands"

PROGRAM = """
import signal
import voz

class Wheels(voz.Robot):
    moving = None
    def move(self, linear, angular):
        if (linear, angular) != self.moving:
            self.moving = linear, angular
            print(f"{linear:g} {angular:g}", flush=True)

signal.signal(signal.SIGTERM, signal.default_int_handler)
try:
    with voz.Controller(Wheels(), safety=voz.Safety(max_linear=0.05), listening=True) as controller:
        controller.run(voz.load().microphone())
except KeyboardInterrupt:
    print("ended", flush=True)
"""


class Wheels(voz.Robot):
    """Keeps what it was asked to do."""

    def __init__(self) -> None:
        self.velocities: list[tuple[float, float]] = []
        self.commands: list[str] = []
        self.is_open = False

    def open(self) -> None:
        self.is_open = True

    def move(self, linear: float, angular: float) -> None:
        self.velocities.append((linear, angular))

    def command(self, name: str, slots: object) -> None:
        self.commands.append(name)

    def close(self) -> None:
        self.is_open = False


def said(*texts: str, pause: float = 0.3) -> Iterator[voz.Utterance]:
    for number, text in enumerate(texts):
        yield voz.Utterance(number, text, 1.0, True, number, number, "test")
        time.sleep(pause)


def test_utterances_drive_a_robot_and_it_stands_when_they_end() -> None:
    robot = Wheels()
    with voz.Controller(robot, listening=True) as controller:
        assert robot.is_open
        controller.run(said("go forward"))
    assert (0.1, 0.0) in robot.velocities
    assert robot.commands == ["go forward"]
    assert robot.velocities[-1] == (0.0, 0.0)
    assert not robot.is_open


def test_a_robot_has_one_controller_at_a_time() -> None:
    robot = Wheels()
    with voz.Controller(robot, listening=True) as first:
        with pytest.raises(voz.RobotError, match="another controller drives this robot already"):
            voz.Controller(robot, listening=True).__enter__()
        assert robot.is_open
        with voz.Controller(Wheels()):
            first.run(said("go forward"))
    assert (0.1, 0.0) in robot.velocities
    with voz.Controller(robot, listening=True) as second:
        second.run(said("go back"))
    assert (-0.1, 0.0) in robot.velocities


def test_commands_do_what_the_program_says() -> None:
    robot = Wheels()
    commands = {"fly": {"drive": 0.15}, "go back": {"rotate": 0.5}}
    with voz.Controller(robot, listening=True, commands=commands) as controller:
        controller.run(said("fly", "go back"))
    moved = [velocity for velocity in dict.fromkeys(robot.velocities) if velocity != (0.0, 0.0)]
    assert moved == [(0.15, 0.0), (0.0, 0.5)]


@pytest.mark.parametrize(
    "error", [ValueError, asyncio.CancelledError, SystemExit, KeyboardInterrupt, GeneratorExit]
)
def test_whatever_ends_the_utterances_stops_the_robot_and_is_raised(
    error: type[BaseException],
) -> None:
    def ending() -> Iterator[voz.Utterance]:
        yield from said("go forward")
        raise error

    robot = Wheels()
    with voz.Controller(robot, listening=True) as controller, pytest.raises(error):
        controller.run(ending())
    assert (0.1, 0.0) in robot.velocities
    assert robot.velocities[-1] == (0.0, 0.0)


def fail_while_moving(controller: voz.Controller) -> None:
    controller.hear(next(said("go forward")))
    controller.send(0.1)
    raise ValueError("mine")


def test_an_error_in_the_block_stops_the_robot() -> None:
    robot = Wheels()
    with (
        pytest.raises(ValueError, match="mine"),
        voz.Controller(robot, listening=True) as controller,
    ):
        fail_while_moving(controller)
    assert robot.velocities[-1] == (0.0, 0.0)


def test_what_cannot_be_is_one_line() -> None:
    with pytest.raises(voz.ConfigError, match="is not open; use `with"):
        voz.Controller(Wheels()).run([])
    with pytest.raises(voz.ConfigError, match="commands: "):
        voz.Controller(Wheels(), commands={"fly": {"no_such_step": 1}})
    with pytest.raises(voz.ConfigError):
        voz.Controller(Wheels(), commands={"stop": {"drive": 0.1}})


@pytest.mark.realtime
@pytest.mark.slow
def test_a_microphone_drives_a_robot(pulse: dict[str, str]) -> None:
    command = [sys.executable, "-c", PROGRAM]
    with subprocess.Popen(command, env=pulse, stdout=subprocess.PIPE, text=True) as process:
        lines: list[str] = []
        reader = Thread(target=_read, args=(process, lines), daemon=True)
        reader.start()
        wait_until(lambda: lines == ["0 0"])
        for text, velocity in (("go_forward", "0.05 0"), ("stop", "0 0")):
            speak_until(pulse, text, lambda wanted=velocity: lines[-1] == wanted)
        assert "0.05 0" in lines
        process.terminate()
        assert process.wait(PATIENCE) == 0
        reader.join(30)
    assert lines[-1] == "ended"


def _read(process: subprocess.Popen[str], lines: list[str]) -> None:
    assert process.stdout is not None
    for line in process.stdout:
        lines.append(line.strip())


def speak_until(pulse: dict[str, str], text: str, done: Callable[[], bool]) -> None:
    """Speak a clip; again where the machine was too slow to follow, which stops the robot."""
    deadline = time.monotonic() + 60
    while not done():
        assert time.monotonic() < deadline, text
        clip = SAID / f"festival_slt__{text}.flac"
        subprocess.run(["paplay", "--device=mic", str(clip)], env=pulse, check=True)
        with suppress(TimeoutError):
            wait_until(done, 3)


def wait_until(done: Callable[[], bool], seconds: float = PATIENCE) -> None:
    deadline = time.monotonic() + seconds
    while not done():
        if time.monotonic() > deadline:
            raise TimeoutError
        time.sleep(0.02)


ASLEEP = """
import voz
recognizer = voz.load(["go forward", "stop"])
with voz.Controller(voz.Robot()) as controller:
    try:
        controller.run(recognizer.microphone())
    except voz.ConfigError as error:
        print(error)
"""


@pytest.mark.slow
def test_a_list_that_cannot_begin_is_one_line(pulse: dict[str, str]) -> None:
    command = [sys.executable, "-c", ASLEEP]
    done = subprocess.run(command, env=pulse, capture_output=True, text=True, check=True)
    assert done.stdout == (
        'no command begins the listening; add "start speech" to the list, or give listening=True\n'
    )
