"""What kept a live run from stopping the robot once: none of it does.

The robot of these tests writes down what reaches it: what the program itself says of it may be what
is held up.
"""

from __future__ import annotations

import json
import os
import random
import re
import signal
import subprocess
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import pytest
from calls import VOZ
from live_robot import live_robot, moves, rests, signals_as_a_terminal_has_them, warns

from voz.config import default_commands
from voz.speech.speech_cache import cached_speech

pytestmark = pytest.mark.slow

EVENTS = ("--events", "log.jsonl")

BASE = """
import json, re, sys, time
from pathlib import Path
from voz.events import Twist
from voz.robot.base import Robot

HERE = Path(__file__).parent

class Base(Robot):
    def open(self):
        self.log = open(HERE / "log", "a", buffering=1)

    def receive(self, event):
        if isinstance(event, Twist):
            self.log.write(json.dumps(event.linear) + "\\n")

    def close(self):
        self.log.write('"closed"\\n')

class Chatty(Base):
    said = 0
    def lost(self):
        Chatty.said += 1
        return "gone " * 2000 if (HERE / "fault").exists() and self.said % 2 else None

class Unspeakable(Exception):
    def __str__(self):
        raise ValueError

class Faulty(Base):
    def receive(self, event):
        super().receive(event)
        if (HERE / "fault").exists() and isinstance(event, Twist) and event.linear:
            fault = (HERE / "fault").read_text()
            (HERE / "fault").unlink()
            exec(fault)
"""


class Watched:
    """A `voz run` whose robot is a class of the module above, and what that got."""

    def __init__(self, folder: Path, process: subprocess.Popen[bytes]) -> None:
        self.folder = folder
        self.process = process

    def got(self) -> list[float | str]:
        log = self.folder / "log"
        lines = log.read_text().splitlines(keepends=True) if log.exists() else []
        return [json.loads(line) for line in lines if line.endswith("\n")]

    def wait_for(self, velocity: float | str) -> None:
        self.wait_until(lambda: self.got()[-1:] == [velocity])

    def wait_until(self, happens: Callable[[], bool]) -> None:
        deadline = time.monotonic() + 30
        while not happens():
            assert time.monotonic() < deadline, f"{self.got()[-5:]}\n{self.told()}"
            time.sleep(0.01)

    def events(self) -> list[dict[str, Any]]:
        log = self.folder / "log.jsonl"
        lines = log.read_text().splitlines(keepends=True) if log.exists() else []
        return [json.loads(line) for line in lines if line.endswith("\n")]

    def told(self) -> list[dict[str, Any]]:
        """Return the last events besides velocities: what was heard, and warnings."""
        return [event for event in self.events() if event["type"] != "cmd_vel"][-10:]

    def type(self, text: bytes) -> None:
        assert self.process.stdin
        self.process.stdin.write(text)
        self.process.stdin.flush()

    def fault(self, text: str = "") -> None:
        (self.folder / "fault").write_text(text)


@contextmanager
def watched(
    folder: Path, environment: dict[str, str], kind: str = "Base", *arguments: str
) -> Iterator[Watched]:
    """Nobody reads what it prints, on the same pipe for both of its outputs."""
    (folder / "base.py").write_text(BASE)
    ours, theirs = os.pipe()
    with subprocess.Popen(
        [*VOZ, "run", "--listening", "--robot", f"base:{kind}", *EVENTS, *arguments],
        cwd=folder,
        env=environment,
        stdin=subprocess.PIPE,
        stdout=theirs,
        stderr=theirs,
        preexec_fn=signals_as_a_terminal_has_them,
    ) as process:
        os.close(theirs)
        try:
            run = Watched(folder, process)
            run.wait_for(0.0)
            yield run
        finally:
            process.send_signal(signal.SIGCONT)
            process.kill()
            os.close(ours)


@pytest.mark.realtime
def test_after_a_pause_of_the_process_the_motion_is_over(
    tmp_path: Path, pulse: dict[str, str]
) -> None:
    with watched(tmp_path, pulse, "Base", "--no-sound") as run:
        run.type(b"go forward\n")
        run.wait_for(0.1)
        run.process.send_signal(signal.SIGSTOP)
        run.wait_for(0.0)  # the watchdog's
        time.sleep(1)
        so_far = len(run.got())
        run.process.send_signal(signal.SIGCONT)
        run.wait_until(lambda: len(run.got()) > so_far + 10)
        assert set(run.got()[so_far:]) == {0.0}
        run.type(b"go back\n")
        run.wait_for(-0.1)


def test_killed_without_a_word_it_leaves_zero_behind(tmp_path: Path, pulse: dict[str, str]) -> None:
    with watched(tmp_path, pulse, "Base", "--no-sound") as run:
        run.type(b"go forward\n")
        run.wait_for(0.1)
        run.process.kill()
        run.wait_for("closed")
        assert run.got()[-2] == 0.0


def test_without_the_watchdog_the_pause_is_seen_all_the_same(pulse: dict[str, str]) -> None:
    with live_robot(pulse, "--listening", "--no-watchdog") as robot:
        robot.type("go forward")
        robot.wait_for(moves)
        robot.process.send_signal(signal.SIGSTOP)
        time.sleep(1)
        since = len(robot.arrived)
        robot.process.send_signal(signal.SIGCONT)
        robot.wait_for(warns("control loop stalled for"), since)
        robot.wait_for(rests, since)
        robot.wait_for(rests, len(robot.arrived) + 5)
        assert not any(moves(arrived.event) for arrived in robot.arrived[since + 1 :])


@pytest.mark.parametrize("seed", range(12))
def test_a_signal_at_any_moment_of_the_start_ends_it_with_zero(
    seed: int, tmp_path: Path, pulse: dict[str, str]
) -> None:
    (tmp_path / "base.py").write_text(BASE)
    chance = random.Random(seed)
    command = [*VOZ, "run", "--listening", "--no-sound", "--robot", "base:Base"]
    with subprocess.Popen(
        command,
        cwd=tmp_path,
        env=pulse,
        stdin=subprocess.PIPE,
        stdout=subprocess.DEVNULL,
        stderr=subprocess.PIPE,
        preexec_fn=signals_as_a_terminal_has_them,
    ) as process:
        assert process.stdin and process.stderr  # noqa: PT018
        process.stdin.write(b"go forward\n")
        process.stdin.flush()
        first, second = chance.sample([signal.SIGINT, signal.SIGTERM, signal.SIGHUP], 2)
        time.sleep(chance.uniform(0.08, 1.2))
        process.send_signal(first)
        # A signal that comes before Python is there, or when it is gone again, has no exit code.
        codes = [128 + first, -first]
        if chance.random() < 0.5:
            time.sleep(chance.uniform(0, 0.1))
            process.send_signal(second)
            codes += [-second, 128 + second]  # of two that wait for it Python takes the lower first
        code = process.wait(30)
        lines = process.stderr.read().splitlines(keepends=True)
        told = b"".join(line for line in lines if not line.startswith(b"listening to "))
    if told.startswith(b"Fatal Python error: init_"):  # Ctrl-C while Python itself starts
        assert code == 1 or code in codes
        return
    assert code in codes
    if code == -signal.SIGINT:
        # Python was there, but not voz: its own answer to Ctrl-C is a traceback.
        assert not told or (told.endswith(b"KeyboardInterrupt\n") and b"in main\n" not in told)
    elif code < 0 and first == signal.SIGINT:  # another signal ended it in the midst of that
        assert b"in main\n" not in told
    else:
        assert told == b""
    time.sleep(0.5)
    run = Watched(tmp_path, process)
    run.wait_until(lambda: run.got()[-2:] in ([], [0.0, "closed"], ["closed"]))


@pytest.mark.realtime
def test_outputs_that_nobody_reads_hold_up_neither_stop_nor_the_end(
    tmp_path: Path, pulse: dict[str, str]
) -> None:
    with watched(tmp_path, pulse, "Chatty", "--no-sound") as run:
        run.fault()  # its warnings fill the pipe
        time.sleep(4)
        (run.folder / "fault").unlink()
        time.sleep(0.5)
        run.type(b"go forward\n")
        run.wait_for(0.1)
        run.type(b"stop\n")
        run.wait_for(0.0)
        run.type(b"go back\n")
        run.wait_for(-0.1)
        run.process.terminate()
        run.wait_for("closed")
        assert run.got()[-2] == 0.0
        assert run.process.wait(30) == 143


@pytest.mark.parametrize("locale", ["C.UTF-8", "POSIX"])
def test_a_byte_that_is_no_text_is_no_command_and_stop_still_works(
    locale: str, tmp_path: Path, pulse: dict[str, str]
) -> None:
    environment = pulse | {"LC_ALL": locale}
    with watched(tmp_path, environment, "Base", "--no-sound") as run:
        run.type(b"go forward\n")
        run.wait_for(0.1)
        run.type(b"\xff\xfe\n\xc3\nstop\n")
        run.wait_for(0.0)
        run.type(b"go back\n")
        run.wait_for(-0.1)
        run.process.terminate()
        assert run.process.wait(30) == 143
    assert "��" in [event.get("text") for event in run.events()]


def test_a_stop_behind_thousands_of_lines_comes_before_them_and_all_are_counted(
    tmp_path: Path, pulse: dict[str, str]
) -> None:
    def dropped() -> list[int]:  # one number, and one more for each 5 s that it takes
        texts = [str(event.get("text")) for event in run.events()]
        told = [re.match("([0-9]+) messages came too fast", text) for text in texts]
        return [int(found[1]) for found in told if found]

    def refused() -> int:
        return sum(event.get("reason") == "not_a_command" for event in run.events())

    with watched(tmp_path, pulse, "Base", "--no-sound") as run:
        run.type(b"go forward\n")
        run.wait_for(0.1)
        run.type(b"what is all this nonsense here\n" * 3000 + b"stop\n")
        run.wait_until(lambda: any(event.get("text") == "stop" for event in run.events()))
        so_far = run.events()
        run.wait_for(0.0)
        run.wait_until(lambda: sum(dropped()) + refused() >= 3000)
        run.process.terminate()
        assert run.process.wait(30) == 143
    assert sum(dropped()) + refused() == 3000
    assert len(dropped()) < 5
    assert len(so_far) < 1000


def test_a_cache_of_replies_that_hangs_does_not_hold_up_stop(
    tmp_path: Path, pulse: dict[str, str], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path))
    replies = [cached_speech(reply, "kal_diphone") for reply in default_commands().replies]
    environment = pulse | {"XDG_CACHE_HOME": str(tmp_path)}
    with watched(tmp_path, environment) as run:
        for reply in replies:
            reply.unlink()
            os.mkfifo(reply)
        run.type(b"go forward\n")
        run.wait_for(0.1)
        run.type(b"stop speech\n")
        run.wait_for(0.0)
        run.type(b"start speech\ngo back\n")
        run.wait_for(-0.1)
        run.type(b"stop\n")
        run.wait_for(0.0)


@pytest.mark.parametrize(
    "fault",
    [
        "sys.exit(3)",
        "raise KeyboardInterrupt",
        "raise Unspeakable",
        "time.sleep(3)",
        "re.fullmatch('(a+)+', 'a' * 25 + 'b')",
    ],
)
def test_a_robot_that_fails_is_stopped_and_closed_and_the_run_goes_on(
    fault: str, tmp_path: Path, pulse: dict[str, str]
) -> None:
    with watched(tmp_path, pulse, "Faulty", "--no-sound") as run:
        run.fault(fault)
        run.type(b"go forward\n")
        run.wait_until(lambda: 0.1 in run.got())
        run.wait_for(0.0)
        assert not (tmp_path / "fault").exists()
        so_far = len(run.got())
        run.wait_until(lambda: len(run.got()) > so_far + 10)
        assert set(run.got()[so_far:]) == {0.0}
        run.process.terminate()
        assert run.process.wait(30) == 143
        run.wait_for("closed")
    log = (tmp_path / "log.jsonl").read_text()
    assert "the robot base:Faulty is lost (" in log
    assert json.loads(log.splitlines()[-1])["linear"] == 0


def test_a_robot_that_never_lets_go_of_python_holds_up_nobody_else(
    tmp_path: Path, pulse: dict[str, str]
) -> None:
    with watched(tmp_path, pulse, "Faulty", "--no-sound") as run:
        run.fault("re.fullmatch('(a+)+', 'a' * 60 + 'b')")
        run.type(b"go forward\n")
        log = tmp_path / "log.jsonl"
        run.wait_until(lambda: "does not take its events" in log.read_text())
        lines = len(log.read_text().splitlines())
        run.wait_until(lambda: len(log.read_text().splitlines()) > lines + 20)
        run.process.terminate()
        assert run.process.wait(30) == 143
    assert json.loads(log.read_text().splitlines()[-1])["linear"] == 0
