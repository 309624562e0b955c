"""What is hunted: `voz run` by a microphone or a text, with robots of several kinds, and ROS 1."""

from __future__ import annotations

import functools
import json
import os
import subprocess
import sys
import threading
import time
from contextlib import ExitStack, suppress
from pathlib import Path
from random import Random

from calls import VOZ
from live_robot import broken_recognizer, speak
from pulseaudio import running_server, sound_server
from recordings import FIXTURES, ROOT
from ros1.ros import STRING, Ros
from ros2_domain import free_domain

from hunting.observing import Observer, Seen
from hunting.quarry import Quarry, started

TARGETS = ("live", "robot", "text", "ros1", "ros2")

HERE = Path(__file__).parent
ROS1_CLIENT = ROOT / "tests" / "ros1" / "client.cjs"
ROS2_PEER = ROOT / "tests" / "ros2" / "cyclone_peer.py"

# A thread dies: an exception is raised in it, as by a bug. And it tells where its threads are.
DEADLY = """
import builtins, ctypes, faulthandler, os, signal, threading, time
faulthandler.register(signal.SIGUSR1, open({stacks!r}, "w"))
def kill():
    while True:
        time.sleep(0.02)
        if os.path.exists({file!r}):
            name, error = open({file!r}).read().split()
            threads = sorted(threading.enumerate(), key=lambda thread: thread.name)
            others = [thread for thread in threads if thread.name.startswith("voz-")]
            named = [thread for thread in threads if thread.name == name]
            thread = others[int(name) % len(others)] if name.isdigit() else named[0]
            os.rename({file!r}, {file!r} + " " + thread.name)
            raised = ctypes.py_object(getattr(builtins, error))
            ctypes.pythonapi.PyThreadState_SetAsyncExc(ctypes.c_ulong(thread.ident), raised)
threading.Thread(target=kill, daemon=True).start()
"""


class Run(Quarry):
    """A `voz run`.

    Attributes:
        server: the sound server, if it has a microphone.
    """

    def __init__(self, target: str, chance: Random, folder: Path, parts: ExitStack) -> None:
        terminal = target != "text" and chance.random() < 0.4
        paths = os.pathsep.join([str(HERE), str(ROOT), os.environ.get("PYTHONPATH", "")])
        environment = {**os.environ, "PYTHONPATH": paths, "TERM": "xterm"}
        environment["HUNT_OBSERVER"] = str(folder / "observer")
        environment["HUNT_ROBOT_FAULT"] = str(folder / "do robot")
        super().__init__(folder, environment, terminal, one=chance.random() < 0.5)
        if chance.random() < 0.5:
            self.setup.append("in a locale of strict UTF-8")
            environment["PYTHONIOENCODING"] = "utf-8:strict"
        self._parts = parts
        self.has |= {target, "run", "keys" if terminal else "lines"}
        robots = ["hunted_robot:Base", "hunted_robot:Bad"][: 2 if target == "robot" else 1]
        arguments = self._read_text() if target == "text" else self._listen()
        if target == "ros2":
            robots = ["ros2"]
            arguments += self._join_ros2()
        robots += chance.choice([[], ["console"], ["simulator"]])
        arguments += ["--listening", "--robot", ",".join(robots)]
        arguments += self._chosen_files(chance) + self._chosen_parts(chance)
        self.setup.append(f"voz run {' '.join(arguments)}")
        self.command_line = self._with_faults(arguments)

    def speak(self, text: str) -> None:
        """Speak a command into the microphone."""
        speak(self.environment, FIXTURES / "commands" / f"festival_slt__{text}.flac")

    def pactl(self, order: str) -> None:
        subprocess.run(["pactl", *order.split()], env=self.environment, check=True)

    def restart_server(self) -> None:
        self.server = self._parts.enter_context(running_server(self.environment))

    def another_recognizer(self, parts: ExitStack) -> tuple[subprocess.Popen[bytes], bytes]:
        """Start what publishes strings; gives the line that lets it publish no command."""
        command = [sys.executable, str(ROS2_PEER)]
        return started(command, self.environment, parts), b"nonsense\n"

    def _with_faults(self, arguments: list[str]) -> list[str]:
        hearing, thread, stacks = self.wish("hearing"), self.wish("thread"), self.folder / "stacks"
        *python, program = VOZ
        before = broken_recognizer(hearing, f"exec(open({str(hearing)!r}).read())")
        before += DEADLY.format(file=str(thread), stacks=str(stacks))
        # What is imported for the faults comes before the program takes signals; it does then.
        blocked = "import signal; signal.pthread_sigmask(signal.SIG_BLOCK, {1, 2, 3, 15})\n"
        return [*python, blocked + before + program, "run", *arguments]

    def _read_text(self) -> list[str]:
        self.has.remove("lines")  # each has its time, and a very long one ends the run
        return ["--text", "-"]

    def _listen(self) -> list[str]:
        environment, self.server = self._parts.enter_context(sound_server())
        self.environment |= {name: environment[name] for name in environment.keys() - os.environ}
        self.environment["HOME"] = environment["HOME"]
        self.has.add("mic")
        return []

    def _join_ros2(self) -> list[str]:
        self.environment["ROS_DOMAIN_ID"] = str(self._parts.enter_context(free_domain()))
        self.environment["ROS_AUTOMATIC_DISCOVERY_RANGE"] = "LOCALHOST"
        started([sys.executable, str(HERE / "ros2_base.py")], self.environment, self._parts)
        self.has.add("strings")
        return ["--listen-ros"]

    def _chosen_files(self, chance: Random) -> list[str]:
        """Choose what it writes: a FIFO nobody reads is a disk that hangs."""
        written = ["--events -", "--events {}/log.jsonl", "--events {}/fifo", "--bag {}/kept.mcap"]
        chosen = chance.choice(["", *written]).format(self.folder)
        if "fifo" in chosen:
            os.mkfifo(self.folder / "fifo")
            self._parts.callback(os.close, os.open(self.folder / "fifo", os.O_RDWR))
        elif chosen and chance.random() < 0.4:
            self.full_disk = True
            self.setup.append("on a disk that is full soon")
        return chosen.split()

    def _chosen_parts(self, chance: Random) -> list[str]:
        """Choose whether it speaks, keeps what it hears, and is watched by another process."""
        arguments = []
        if chance.random() < 0.3:
            self.environment["XDG_CACHE_HOME"] = str(self.folder / "cache")
            self.has.add("speaks")
        else:
            arguments.append("--no-sound")
        if "mic" in self.has and chance.random() < 0.1:
            arguments += ["--record", str(self.folder / "recorded")]
        if watchdog_is_there():
            self.has.add("watchdog")
            if chance.random() < 0.2:
                self.has.remove("watchdog")
                arguments.append("--no-watchdog")
        return arguments


class Node(Quarry):
    """The node `control_voz`, a recognizer and a base, which share no code with rospy.

    Attributes:
        ros: its master.
        recognizer: commands it.
    """

    def __init__(self, chance: Random, folder: Path, parts: ExitStack, observer: Observer) -> None:
        self.ros = Ros(folder, parts)
        environment = self.ros.environment | {"PYTHONPATH": str(ROOT), "TERM": "xterm"}
        super().__init__(folder, environment, chance.random() < 0.4, one=chance.random() < 0.5)
        self.recognizer = self.ros.client()
        base = started(["node", str(ROS1_CLIENT), "/cmd_vel"], environment, parts)
        threading.Thread(target=watch, args=(base, observer), daemon=True).start()
        self.setup.append("control_voz")
        self.has |= {"ros1", "strings", "lines"} | ({"watchdog"} if watchdog_is_there() else set())
        script = str(ROOT / "ros" / "scripts" / "control_voz")
        self.command_line = [script, "_sound:=none", "_listening:=true"]

    def command(self, text: str) -> None:
        """Publish a command, if the recognizer was not killed."""
        with suppress(BrokenPipeError):
            self.recognizer.say(text)

    def another_recognizer(self, parts: ExitStack) -> tuple[subprocess.Popen[bytes], bytes]:
        """Start what publishes strings; gives the line that lets it publish no command."""
        nonsense = {"topic": "/recognizer/output", "data": {"data": "nonsense"}, **STRING}
        process = started(["node", str(ROS1_CLIENT)], self.environment, parts)
        return process, f"{json.dumps(nonsense)}\n".encode()


def watch(base: subprocess.Popen[bytes], observer: Observer) -> None:
    """Let an observer know what a ROS 1 client received, and when."""
    by_the_wall = time.time() - time.monotonic()
    with suppress(ValueError):  # it was closed
        for line in base.stdout or ():
            message = json.loads(line)
            linear, angular = message["data"]["linear"]["x"], message["data"]["angular"]["z"]
            observer.seen.append(Seen("ros1", message["at"] - by_the_wall, linear, angular))


def quarry(
    target: str, chance: Random, folder: Path, parts: ExitStack, observer: Observer
) -> Run | Node:
    """Prepare a target of `TARGETS`, set up as chance has it."""
    if target == "ros1":
        return Node(chance, folder, parts, observer)
    return Run(target, chance, folder, parts)


@functools.cache
def watchdog_is_there() -> bool:
    """Whether this voz watches itself from another process."""
    told = subprocess.run([*VOZ, "run", "--help"], capture_output=True, text=True, check=True)
    return "--no-watchdog" in told.stdout
