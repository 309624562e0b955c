"""A program that drives a robot elsewhere; whether it always stops: `tests/promises`."""

from __future__ import annotations

import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path

import pytest
from live_robot import moves, rests
from operator_page import PageRobot, opened, page_robot
from recordings import ROOT

import voz

pytestmark = pytest.mark.slow


@pytest.fixture(scope="module")
def one_run(no_sound_card: dict[str, str]) -> Iterator[PageRobot]:
    with page_robot(no_sound_card, "--listening") as robot:
        yield robot


@pytest.mark.realtime
def test_a_command_is_answered_and_the_robot_stops_when_the_block_ends(robot: PageRobot) -> None:
    since = robot.since
    with voz.Client(robot.link) as client:
        assert client.command("Go  forward").obeyed
        robot.robot.wait_for(moves, since)
        refused = client.command("make coffee")
        assert (bool(refused), refused.reason) == (False, "not_a_command")
    robot.robot.wait_for(rests, robot.since)


def test_stop_is_confirmed(robot: PageRobot) -> None:
    with voz.Client(robot.link) as client:
        client.command("go forward")
        since = robot.since
        stopped = client.command("stop")
        assert robot.robot.wait_for(rests, since).event["t"] == stopped.t
        assert client.stop() > stopped.t


def test_who_has_taken_over_keeps_the_robot(robot: PageRobot) -> None:
    with voz.Client(robot.link) as client, opened(robot) as page:
        client.command("go forward")
        assert page.drive(over=True)
        robot.robot.wait_for(rests, robot.since)
        with pytest.raises(voz.RobotError, match="drives"):
            client.command("go forward")


def test_the_example_drives(robot: PageRobot) -> None:
    command = [sys.executable, str(ROOT / "examples" / "client.py"), robot.link]
    done = subprocess.run(command, capture_output=True, text=True, check=True)
    assert done.stdout == "start speech is obeyed\ngo forward is obeyed\n"
    robot.robot.wait_for(rests, robot.since)


@pytest.mark.parametrize("address", ["robot:8737", "ftp://robot", "http://", "http://[::1", "h"])
def test_what_is_no_address_is_refused(address: str) -> None:
    with pytest.raises(voz.ConfigError, match="is no address of an operator page; give the whole"):
        voz.Client(address)


def test_who_is_no_robot_is_reported(tmp_path: Path) -> None:
    with pytest.raises(voz.RobotError, match=r"http://127.0.0.1:9: .*refused; nothing listens"):
        voz.Client("http://127.0.0.1:9")
    with pytest.raises(voz.ConfigError, match=r"authority .*nowhere.crt: "):
        voz.Client("https://127.0.0.1:9", authority=tmp_path / "nowhere.crt")
