"""A `voz run --web` in a process of its own, and programs that use its API."""

from __future__ import annotations

import json
import queue
import re
import struct
import threading
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress
from http import HTTPStatus
from pathlib import Path
from typing import Any

import httpx
import numpy as np
from live_robot import LiveRobot, live_robot
from programs import PATIENCE, wait_until
from websockets.exceptions import ConnectionClosed
from websockets.sync.client import ClientConnection, connect

from voz.audio import SAMPLE_RATE, Samples
from voz.audio.sound_files import read_samples
from voz.language.build import build

BLOCK = 480
"""Samples of a block, 30 ms."""

Record = dict[str, Any]


class PageRobot:
    """A robot with an operator page, and its API."""

    def __init__(self, robot: LiveRobot) -> None:
        self.robot = robot
        wait_until(lambda: "://" in robot.words)
        found = re.search(r"(http\S+)\n", robot.words)
        assert found
        link, _, self.token = str(found[1]).partition("#token=")
        self.link = re.sub(r"//[^/]*:", "//127.0.0.1:", link)
        self.api = httpx.Client(base_url=self.link, timeout=PATIENCE, verify=False)

    @property
    def state(self) -> Record:
        answer: Record = self.api.get("/api/state").raise_for_status().json()
        return answer

    @property
    def since(self) -> int:
        """How many events there were until now, once all of them have arrived here."""
        now = self.state["now"]["t"]
        wait_until(lambda: self.robot.arrived[-1].event["t"] > now)
        return len(self.robot.arrived)

    def command(self, text: str, **more: object) -> httpx.Response:
        return self.api.post("/api/command", json={"text": text, **more})

    def drives(self, text: str) -> None:
        """Give a command as a program, as soon as its limit allows, and see that it is obeyed."""
        answers: list[httpx.Response] = []

        def is_let_in() -> bool:
            answers.append(self.command(text))
            return answers[-1].status_code != HTTPStatus.TOO_MANY_REQUESTS

        wait_until(is_let_in)
        assert answers[-1].raise_for_status().json()["obeyed"]


class Page:
    """What a page does, without a browser: it answers states, whatever else goes on."""

    def __init__(self, socket: ClientConnection) -> None:
        self.socket = socket
        self.there = True  # whether somebody sees it; it answers nothing else
        self._told: queue.SimpleQueue[Record | ConnectionClosed] = queue.SimpleQueue()
        threading.Thread(target=self._read, daemon=True).start()
        self.welcome = self.wait_for(lambda record: record["type"] == "welcome")

    def _read(self) -> None:
        try:
            while True:
                record = json.loads(self.socket.recv())
                if record["type"] == "state" and self.there:
                    self.send("seen")
                self._told.put(record)
        except ConnectionClosed as closed:
            self._told.put(closed)

    def send(self, kind: str, **more: object) -> None:
        self.socket.send(json.dumps({"type": kind, **more}))

    def _next(self, until: float) -> Record:
        """Take what comes next, up to a time on the monotonic clock."""
        record = self._told.get(timeout=max(0.0, until - time.monotonic()))
        if isinstance(record, ConnectionClosed):
            raise record
        return record

    def wait_for(self, sought: Callable[[Record], object]) -> Record:
        """Take what comes up to what is sought."""
        until = time.monotonic() + PATIENCE
        while not sought(record := self._next(until)):
            pass
        return record

    def drive(self, over: bool = False) -> bool:
        self.send("drive", over=over)
        return bool(self.wait_for(lambda record: record["type"] == "drive")["driving"])

    def start_driving(self) -> None:
        """Drive, once the server knows that whoever drove before is gone."""
        wait_until(self.drive)

    def stay(self, seconds: float) -> None:
        """Let pass what comes in some time."""
        until = time.monotonic() + seconds
        with suppress(queue.Empty):
            while True:
                self._next(until)


class Microphone:
    """The sound of a page, over its own WebSocket; the questions for its time are answered."""

    def __init__(self, socket: ClientConnection, page: Page, rate: int = SAMPLE_RATE) -> None:
        self.socket = socket
        self._number = 0
        self._asked = threading.Event()
        self._told: queue.SimpleQueue[Record | None] = queue.SimpleQueue()
        self._send(type="hello", page=page.welcome["secret"], rate=rate)
        threading.Thread(target=self._read, daemon=True).start()
        assert self._asked.wait(PATIENCE)

    def _send(self, **message: object) -> None:
        self.socket.send(json.dumps(message))

    def _read(self) -> None:
        with suppress(ConnectionClosed):
            while True:
                record = json.loads(self.socket.recv())
                if record["type"] == "ping":
                    self._send(type="pong", t=record["t"], at=time.time() * 1000)
                    self._asked.set()
                else:
                    self._told.put(record)
        self._told.put(None)

    def begin(self) -> None:
        self._send(type="begin")

    def end(self) -> None:
        self._send(type="end")

    def block(self, samples: Samples, late: float = 0.0) -> None:
        """Send a block that was heard so many seconds ago."""
        header = struct.pack("<IId", self._number, 0, (time.time() - late) * 1000)
        self._number += 1
        self.socket.send(header + samples.astype("<i2").tobytes())

    def told(self) -> Record | None:
        """What it is told next besides those questions; None once the server has closed it."""
        return self._told.get(timeout=PATIENCE)

    def skip(self) -> None:
        """Let a block be missing."""
        self._number += 1

    def speak(self, samples: Samples, page: Page, late: float = 0.0) -> None:
        """Send sound as fast as it is heard."""
        begun = time.monotonic()
        for start in range(0, len(samples) - BLOCK, BLOCK):
            self.block(samples[start : start + BLOCK], late)
            left = begun + (start + BLOCK) / SAMPLE_RATE - time.monotonic()
            page.stay(max(0.0, left))


@contextmanager
def page_robot(environment: dict[str, str], *arguments: str, **how: Any) -> Iterator[PageRobot]:
    """A robot in its room with a page, for the length of a `with` block."""
    port = [] if "--web-port" in arguments else ["--web-port", "0"]
    options = ["--web", *port, "--robot", "simulator", *arguments]
    with live_robot(environment, *options, **how) as robot:
        page = PageRobot(robot)
        with page.api:
            yield page


def own_list(folder: Path, commands: str, settings: str) -> list[str]:
    """Write a list of commands, build it, and write what they do; returns the options of a run."""
    (folder / "commands.txt").write_text(commands)
    build(folder / "commands.txt", folder / "lm")
    (folder / "voz.toml").write_text(f'lm = "{folder / "lm"}"\n{settings}')
    return ["--config", str(folder / "voz.toml")]


@contextmanager
def opened(robot: PageRobot, **headers: str) -> Iterator[Page]:
    """A page that is open for the length of a `with` block."""
    with told(robot, **headers) as socket:
        yield Page(socket)


def told(robot: PageRobot, **headers: str) -> ClientConnection:
    """Open the way by which a page is told what happens."""
    address = robot.link.replace("http", "ws", 1) + "api/events"
    return connect(
        address, additional_headers=headers, max_size=None, ping_interval=None, close_timeout=1
    )


@contextmanager
def heard(robot: PageRobot, page: Page, rate: int = SAMPLE_RATE) -> Iterator[Microphone]:
    """A page's microphone, for the length of a `with` block."""
    address = robot.link.replace("http", "ws", 1) + "api/audio"
    with connect(address, ping_interval=None, close_timeout=1) as socket:
        yield Microphone(socket, page, rate)


def with_noise(clip: Path, before: float, after: float) -> Samples:
    """A clip in a quiet room that is heard before and after it, for so many seconds each."""
    spoken = read_samples(clip)
    ends = [np.zeros(round(seconds * SAMPLE_RATE), np.int16) for seconds in (before, after)]
    sound = np.concatenate([ends[0], spoken, ends[1]])
    return sound + room_noise(len(sound) / SAMPLE_RATE)[: len(sound)]


def room_noise(seconds: float) -> Samples:
    """What a microphone gives in a quiet room: none that is on gives exact zeros."""
    quiet = np.random.default_rng(0).integers(-2, 3, round(seconds * SAMPLE_RATE))
    return quiet.astype(np.int16)
