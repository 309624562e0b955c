"""The promises at one more door: `voz.Client`, programs of its own and a real page server."""

from __future__ import annotations

import os
import signal
import socket
import subprocess
import sys
import threading
from collections.abc import Iterator
from contextlib import suppress
from typing import Any
from urllib.error import HTTPError
from urllib.parse import urlsplit
from urllib.request import Request, urlopen

import pytest
from live_robot import moves, rests, warns
from operator_page import PageRobot, opened, page_robot
from programs import PATIENCE

import voz

pytestmark = pytest.mark.slow

DRIVE_ON = """
import sys, voz
robot = voz.Client(sys.argv[1])
print(robot.command("go forward").obeyed, flush=True)
sys.stdin.read()
"""

SETTINGS = """[commands]
"go back" = { drive = -0.1, confirm = "shall I?" }
"point beer" = { answer = true }
"point cocacola" = { answer = false }
"""

YES = "point beer"


@pytest.fixture(scope="module")
def one_run(tmp_path_factory: pytest.TempPathFactory) -> Iterator[PageRobot]:
    folder = tmp_path_factory.mktemp("run")
    (folder / "voz.toml").write_text(SETTINGS)
    (folder / "alsa.conf").write_text("pcm.default { type hw card 99 }")  # there is no sound card
    environment = os.environ | {"ALSA_CONFIG_PATH": str(folder / "alsa.conf")}
    settings = ("--config", str(folder / "voz.toml"))
    with page_robot(environment, "--listening", *settings) as robot:
        yield robot


@pytest.fixture
def robot(one_run: PageRobot) -> PageRobot:
    """The same run for all tests, with the robot at rest at the beginning of each."""
    one_run.api.post("/api/stop").raise_for_status()
    return one_run


def stands(robot: PageRobot, since: int) -> None:
    """It stands, and goes on to stand."""
    stood = robot.robot.arrived.index(robot.robot.wait_for(rests, since))
    robot.robot.wait_for(rests, len(robot.robot.arrived) + 5)
    assert not any(moves(arrived.event) for arrived in robot.robot.arrived[stood:])


@pytest.mark.parametrize("text", ["stop", "please stop", "stop stop", "stop speech"])
def test_what_stops_it_does_whoever_drives(robot: PageRobot, text: str) -> None:
    with opened(robot) as page, voz.Client(robot.link) as client:
        page.start_driving()
        with pytest.raises(voz.RobotError, match=r"drives; end that first"):
            client.command("go forward")
        since = robot.since
        robot.command("go forward", page=page.welcome["secret"]).raise_for_status()
        robot.robot.wait_for(moves, since)
        since = robot.since
        assert client.command(text).obeyed
        stands(robot, since)
    robot.drives("start speech")


def test_what_asks_first_is_done_after_a_yes_alone_and_zero_comes_last(robot: PageRobot) -> None:
    with voz.Client(robot.link) as client:
        since = robot.since
        assert not client.command("go back").obeyed
        assert client.command("stop").obeyed
        client.command(YES)
        stands(robot, since)
        client.command("go back")
        since = robot.since
        assert client.command(YES).obeyed
        robot.robot.wait_for(moves, since)
        since = robot.since
    stands(robot, since)


def test_a_stop_overtakes_a_command_that_is_on_its_way(
    robot: PageRobot, monkeypatch: pytest.MonkeyPatch
) -> None:
    with voz.Client(robot.link) as client:
        since, stops = robot.since, [client.stop]

        def send(request: Request, **options: Any) -> Any:
            if request.full_url.endswith("/api/command") and stops:
                stops.pop()()
            return urlopen(request, **options)

        monkeypatch.setattr("voz.apps.web.client.urlopen", send)
        with pytest.raises(voz.RobotError, match="a stop came after it"):
            client.command("go forward")
        stands(robot, since)


@pytest.mark.parametrize("number", [signal.SIGKILL, signal.SIGSTOP, signal.SIGINT])
def test_a_program_that_is_killed_or_suspended_leaves_no_robot_moving(
    robot: PageRobot, number: int
) -> None:
    command = [sys.executable, "-c", DRIVE_ON, robot.link]
    with subprocess.Popen(
        command, stdin=subprocess.PIPE, stdout=subprocess.PIPE, stderr=subprocess.DEVNULL
    ) as program:
        assert program.stdout
        assert program.stdout.readline() == b"True\n"
        since = robot.since
        robot.robot.wait_for(moves, since)
        program.send_signal(number)
        robot.robot.wait_for(warns("the operator's page is gone"), since)
        stands(robot, since)
        program.kill()


class Wire:
    """Passes connections on to a server; those that are there may fall silent in both ways."""

    def __init__(self, link: str) -> None:
        self._server = urlsplit(link)
        self._listening = socket.create_server(("127.0.0.1", 0))
        self.link = f"http://127.0.0.1:{self._listening.getsockname()[1]}"
        self._silent = threading.Event()
        self._open = [self._listening]
        self._threads = [threading.Thread(target=self._accept)]
        self._threads[0].start()

    def fall_silent(self) -> None:
        """Take and give nothing more, and close nothing."""
        self._silent.set()
        self._silent = threading.Event()

    def close(self) -> None:
        for end in self._open:
            with suppress(OSError):
                end.shutdown(socket.SHUT_RDWR)
        for thread in self._threads:
            thread.join()
        for end in self._open:
            end.close()

    def _accept(self) -> None:
        with suppress(OSError):
            while True:
                here, _ = self._listening.accept()
                there = socket.create_connection((self._server.hostname, self._server.port))
                self._open += [here, there]
                for ends in ((here, there), (there, here)):
                    self._threads.append(threading.Thread(target=pump, args=(*ends, self._silent)))
                    self._threads[-1].start()


def pump(source: socket.socket, target: socket.socket, silent: threading.Event) -> None:
    with suppress(OSError):
        while data := source.recv(65536):
            if not silent.is_set():
                target.sendall(data)
        target.shutdown(socket.SHUT_WR)


def test_a_program_whose_connection_hangs_stops_it_and_moves_it_by_no_other(
    robot: PageRobot, monkeypatch: pytest.MonkeyPatch
) -> None:
    sent: list[Request] = []

    def send(request: Request, **options: Any) -> Any:
        sent.append(request)
        return urlopen(request, **options)

    monkeypatch.setattr("voz.apps.web.client.urlopen", send)
    wire = Wire(robot.link)
    client = voz.Client(wire.link)
    assert client.command("go forward").obeyed
    command = sent[-1]
    since = robot.since
    robot.robot.wait_for(moves, since)
    wire.fall_silent()
    robot.robot.wait_for(warns("the operator's page is gone"), since)
    since = robot.since
    with pytest.raises(HTTPError) as refused:
        urlopen(command, timeout=PATIENCE)  # by a new connection, which works
    with refused.value as answer:
        assert b"counts as gone" in answer.read()
    assert client.stop() > 0
    stands(robot, since - 1)
    client.close()
    wire.close()
    with voz.Client(robot.link) as other:
        since = robot.since
        assert other.command("go forward").obeyed
        robot.robot.wait_for(moves, since)
