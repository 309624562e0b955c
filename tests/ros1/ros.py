"""A real ROS master, the nodes of this package, and a client that shares no code with rospy."""

from __future__ import annotations

import json
import os
import socket
import subprocess
import threading
import time
from collections.abc import Callable, Iterator
from contextlib import ExitStack, contextmanager, suppress
from pathlib import Path
from typing import Any

from programs import PATIENCE, free_port
from recordings import ROOT

HERE = Path(__file__).parent
STRING = {"type": "std_msgs/String", "definition": "string data\n"}


class Ros:
    """A master on a port of its own; everything that is started here ends with it."""

    def __init__(self, folder: Path, parts: ExitStack, **environment: str) -> None:
        self.port = free_port()
        self.environment = os.environ | {
            "ROS_MASTER_URI": f"http://127.0.0.1:{self.port}",
            "ROS_IP": "127.0.0.1",
            "ROS_HOME": str(folder),
            "ROS_PACKAGE_PATH": str(ROOT / "ros"),
            "PYTHONUNBUFFERED": "1",
            **environment,
        }
        self._parts = parts
        self.start_master()

    def start_master(self) -> None:
        self.master = self.start("rosmaster", "--core", "-p", str(self.port))
        eventually(self._answers)

    def _answers(self) -> bool:
        with socket.socket() as knock:
            return knock.connect_ex(("127.0.0.1", self.port)) == 0

    def start(self, *command: str, kind: type[Any] | None = None, env: Any = None) -> Any:
        """Start a program; it is a `Program`, or what is to be made of its process."""
        process = subprocess.Popen(
            command,
            env=self.environment | (env or {}),
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            stderr=subprocess.STDOUT,
            text=True,
        )
        program = (kind or Program)(process)
        self._parts.callback(program.end)
        return program

    def call(self, *command: str, **more: Any) -> subprocess.CompletedProcess[str]:
        environment = self.environment | more.pop("env", {})
        return subprocess.run(
            command, env=environment, capture_output=True, text=True, timeout=60, **more
        )

    def node(self, name: str, *arguments: str, **more: Any) -> Program:
        program: Program = self.start(str(ROOT / "ros" / "scripts" / name), *arguments, **more)
        return program

    def launch(self, file: str, *arguments: str) -> Program:
        program: Program = self.start("roslaunch", "voz", file, *arguments)
        return program

    def client(self, *topics: str) -> Client:
        client: Client = self.start("node", str(HERE / "client.cjs"), *topics, kind=Client)
        return client


class Program:
    """A program that runs, and what it said up to now."""

    def __init__(self, process: Any) -> None:
        self.process = process
        self.lines: list[str] = []
        self._reader = threading.Thread(target=self._read, daemon=True)
        self._reader.start()

    @property
    def text(self) -> str:
        return "".join(self.lines)

    def wait_for(self, text: str) -> None:
        eventually(lambda: text in self.text or self.process.poll() is not None)
        assert text in self.text, self.text

    def type(self, line: str) -> None:
        self.process.stdin.write(f"{line}\n")
        self.process.stdin.flush()

    def wait(self) -> int:
        code: int = self.process.wait(PATIENCE)
        self._reader.join(PATIENCE)
        return code

    def kill(self) -> None:
        self.process.kill()
        self.process.wait()

    def end(self) -> None:
        self.process.terminate()
        try:
            self.process.wait(PATIENCE)  # roslaunch gives its nodes 17 s
        except subprocess.TimeoutExpired:
            self.kill()
        self._reader.join(PATIENCE)
        assert not self._reader.is_alive(), f"what it started still runs: {self.text}"
        with suppress(BrokenPipeError):
            self.process.stdin.close()
        self.process.stdout.close()

    def _read(self) -> None:
        for line in self.process.stdout:
            self.lines.append(line)


class Client(Program):
    """Receives all messages of some topics, and publishes."""

    @property
    def messages(self) -> list[dict[str, Any]]:
        return [json.loads(line) for line in list(self.lines)]

    def of(self, topic: str) -> list[Any]:
        return [message["data"] for message in self.messages if message["topic"] == topic]

    def velocities(self, topic: str = "/cmd_vel") -> list[tuple[float, float]]:
        return [(data["linear"]["x"], data["angular"]["z"]) for data in self.of(topic)]

    def wait_for_velocity(self, linear: float, angular: float, topic: str = "/cmd_vel") -> None:
        eventually(lambda: self.velocities(topic)[-1:] == [(linear, angular)])

    def publish(self, topic: str, **message: Any) -> None:
        self.type(json.dumps({"topic": topic, **message}))

    def say(self, text: str, topic: str = "/recognizer/output") -> None:
        """Publish what a recognizer does; before somebody subscribed nobody gets it."""
        self.publish(topic, data={"data": text}, **STRING)


def eventually(happens: Callable[[], Any], patience: float = PATIENCE) -> None:
    deadline = time.monotonic() + patience
    while not happens():
        assert time.monotonic() < deadline, "it did not happen"
        time.sleep(0.02)


@contextmanager
def running_ros(folder: Path, **environment: str) -> Iterator[Ros]:
    with ExitStack() as parts:
        yield Ros(folder, parts, **environment)
