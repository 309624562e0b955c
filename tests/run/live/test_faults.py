"""What breaks while the robot drives: it stops, says why, and hears again by itself (S5).

How soon it stops is printed by `benchmarks/faults.py`; a test machine is too noisy to assert it.
"""

from __future__ import annotations

import signal
import subprocess
import sys
import time
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

import pytest
from live_robot import LiveRobot, broken_recognizer, live_robot, moves, rests, speak, warns
from pulseaudio import running_server
from recordings import GO_BACK

pytestmark = [pytest.mark.slow, pytest.mark.realtime]

Pulse = tuple[dict[str, str], "subprocess.Popen[bytes]"]

AGAIN = warns("listening again; the robot waits for a command")


@contextmanager
def driving(environment: dict[str, str], before: str = "") -> Iterator[LiveRobot]:
    with live_robot(environment, "--listening", before=before) as robot:
        robot.type("go forward")
        robot.wait_for(moves)
        yield robot


def obeys_the_microphone(robot: LiveRobot, environment: dict[str, str]) -> bool:
    """Whether the robot stood still until now, and a command that is spoken moves it.

    It is said again if it is lost, as it may be on a machine that is busy with other tests.
    """
    since = len(robot.arrived)
    assert rests(robot.of("cmd_vel")[-1])
    speak(environment, GO_BACK)
    try:
        robot.wait_for(moves, since, seconds=10)
    except AssertionError:
        speak(environment, GO_BACK)
        robot.wait_for(moves, since)
    return robot.commands()[-1] == "go back"


def test_a_server_that_is_killed_and_started_again(own_pulse: Pulse) -> None:
    environment, server = own_pulse
    with driving(environment) as robot:
        since = len(robot.arrived)
        server.kill()
        robot.wait_for(warns("the microphone is gone"), since)
        robot.wait_for(rests, since)
        with running_server(environment):
            back = robot.wait_for(AGAIN, since)
            still = robot.arrived[since : robot.arrived.index(back)]
            assert not any(moves(arrived.event) for arrived in still[5:])
            assert obeys_the_microphone(robot, environment)
            assert len(robot.warnings(since)) == 2
            assert robot.end() == 143
    assert "ALSA" not in robot.words  # what libraries say is kept away from the display


def test_a_server_that_hangs_and_goes_on(own_pulse: Pulse) -> None:
    environment, server = own_pulse
    with driving(environment) as robot:
        since = len(robot.arrived)
        server.send_signal(signal.SIGSTOP)
        robot.wait_for(warns("no sound comes from the microphone: the robot stops"), since)
        robot.wait_for(rests, since)
        server.send_signal(signal.SIGCONT)
        robot.wait_for(AGAIN, since)
        assert obeys_the_microphone(robot, environment)


@pytest.mark.parametrize(("number", "code"), [(signal.SIGINT, 130), (signal.SIGTERM, 143)])
def test_while_the_server_hangs_a_signal_still_ends_the_program(
    number: signal.Signals, code: int, own_pulse: Pulse
) -> None:
    environment, server = own_pulse
    with driving(environment) as robot:
        since = len(robot.arrived)
        server.send_signal(signal.SIGSTOP)
        robot.wait_for(warns("no sound"), since)
        assert robot.end(number) == code
        assert rests(robot.arrived[-1].event)


@pytest.mark.parametrize(("how", "off", "on"), [("mute", "1", "0"), ("volume", "0", "100%")])
def test_a_microphone_that_is_muted_while_the_robot_moves_stops_it(
    how: str, off: str, on: str, own_pulse: Pulse
) -> None:
    environment, _ = own_pulse
    with driving(environment) as robot:
        time.sleep(0.5)  # the room is heard
        since = len(robot.arrived)
        switch = ["pactl", f"set-source-{how}", "mic.monitor"]
        subprocess.run([*switch, off], env=environment, check=True)
        robot.wait_for(warns("the microphone gives only silence: the robot stops"), since)
        robot.wait_for(rests, since)
        subprocess.run([*switch, on], env=environment, check=True)
        robot.wait_for(AGAIN, since)
        assert obeys_the_microphone(robot, environment)


def test_a_microphone_that_is_muted_while_the_robot_stands_is_a_warning(own_pulse: Pulse) -> None:
    environment, _ = own_pulse
    subprocess.run(["pactl", "set-source-mute", "mic.monitor", "1"], env=environment, check=True)
    with live_robot(environment, "--listening") as robot:
        robot.wait_for(warns("the microphone gives only silence: is it muted?"))
        assert len(robot.warnings()) == 1


@pytest.mark.parametrize(
    ("fault", "warning"),
    [
        (
            'raise RuntimeError("out of order")',
            "the recognizer fails (RuntimeError('out of order')",
        ),
        ("time.sleep(2)", "the computer is too slow to follow: the robot stops"),
        ("time.sleep(0.06)", "the computer is too slow to follow: the robot stops"),
    ],
)
def test_a_recognizer_that_fails(
    fault: str, warning: str, pulse: dict[str, str], tmp_path: Path
) -> None:
    broken = tmp_path / "broken"
    with driving(pulse, broken_recognizer(broken, fault)) as robot:
        since = len(robot.arrived)
        broken.touch()
        robot.wait_for(warns(warning), since)
        robot.wait_for(rests, since)
        broken.unlink()
        robot.wait_for(AGAIN, since)
        assert obeys_the_microphone(robot, pulse)


def test_sound_that_is_lost_because_nobody_takes_it_is_a_warning(
    pulse: dict[str, str], tmp_path: Path
) -> None:
    broken = tmp_path / "broken"
    with driving(pulse, broken_recognizer(broken, "time.sleep(7)")) as robot:
        since = len(robot.arrived)
        broken.touch()
        robot.wait_for(warns("too slow to follow"), since)
        broken.unlink()
        robot.wait_for(warns("s of sound were lost: the computer is too slow"), since)
        assert obeys_the_microphone(robot, pulse)


def test_on_a_busy_computer_commands_are_obeyed(pulse: dict[str, str]) -> None:
    busy = [subprocess.Popen([sys.executable, "-c", "while True: pass"]) for _ in range(2)]
    try:
        with driving(pulse) as robot:
            robot.type("stop")
            robot.wait_for(rests, len(robot.arrived))
            assert obeys_the_microphone(robot, pulse)
    finally:
        for process in busy:
            process.kill()
            process.wait()
