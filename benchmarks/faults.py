"""How soon the robot stands still when something breaks, and how soon it hears again.

Run `python benchmarks/faults.py [--runs N]`. Each fault is caused for real, in a `voz run` that
drives a robot and listens to a microphone without hardware, of a PulseAudio server of its own. The
first time runs from the fault to zero velocity, the second from its end until the program says that
it hears again, or from a signal until the program has ended. They are measured outside, where the
events arrive; of all runs the worst is printed.
"""

from __future__ import annotations

import argparse
import signal
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable, Iterator
from contextlib import ExitStack, contextmanager
from pathlib import Path
from typing import NamedTuple

from machine import machine

sys.path.insert(0, str(Path(__file__).parent.parent / "tests"))

from live_robot import LiveRobot, broken_recognizer, live_robot, moves, rests, warns
from pulseaudio import running_server, sound_server

LASTS = 2.0
"""How long a fault lasts, s."""


class Took(NamedTuple):
    """Seconds until zero velocity, until it hears again or has ended, and what it warned of."""

    zero: float
    after: float
    warning: str


@contextmanager
def driving(environment: dict[str, str], before: str = "") -> Iterator[LiveRobot]:
    with live_robot(environment, "--listening", before=before) as robot:
        time.sleep(1)
        robot.type("go forward")
        robot.wait_for(moves)
        time.sleep(0.5)
        yield robot


def measure(robot: LiveRobot, cause: Callable[[], object], end: Callable[[], object]) -> Took:
    since = len(robot.arrived)
    caused = time.monotonic()
    cause()
    zero = robot.wait_for(rests, since).when - caused
    time.sleep(LASTS)
    ended = time.monotonic()
    end()
    again = robot.wait_for(warns("listening again"), since).when - ended
    return Took(zero, again, robot.warnings(since)[0])


def server_killed() -> Took:
    with (
        sound_server() as (environment, server),
        driving(environment) as robot,
        ExitStack() as restarted,
    ):
        return measure(
            robot, server.kill, lambda: restarted.enter_context(running_server(environment))
        )


def server_hangs() -> Took:
    with sound_server() as (environment, server), driving(environment) as robot:
        return measure(
            robot,
            lambda: server.send_signal(signal.SIGSTOP),
            lambda: server.send_signal(signal.SIGCONT),
        )


def recognizer_fails(fault: str) -> Took:
    with sound_server() as (environment, _), tempfile.TemporaryDirectory() as folder:
        file = Path(folder) / "broken"
        with driving(environment, broken_recognizer(file, fault)) as robot:
            return measure(robot, file.touch, file.unlink)


def ended(number: signal.Signals, hangs: bool = False) -> Took:
    with sound_server() as (environment, server), driving(environment) as robot:
        if hangs:
            server.send_signal(signal.SIGSTOP)
            time.sleep(0.1)
        sent = time.monotonic()
        code = robot.end(number)
        gone = time.monotonic() - sent
        zero = robot.arrived[-1]
        assert rests(zero.event), "zero velocity was not the last event"
        return Took(zero.when - sent, gone, f"exit code {code}")


@contextmanager
def busy() -> Iterator[None]:
    """Keep both cores, or as many as there are, busy."""
    with ExitStack() as processes:
        for _ in range(2):
            process = subprocess.Popen([sys.executable, "-c", "while True: pass"])
            processes.callback(process.wait)
            processes.callback(process.kill)
        yield


def on_a_busy_computer(fault: Callable[[], Took]) -> Took:
    with busy():
        return fault()


FAULTS: dict[str, Callable[[], Took]] = {
    "sound server killed, started again": server_killed,
    "sound server hangs, goes on": server_hangs,
    "recognizer raises": lambda: recognizer_fails('raise RuntimeError("out of order")'),
    "recognizer hangs for 3 s": lambda: recognizer_fails("time.sleep(3)"),
    "recognizer takes twice the time": lambda: recognizer_fails("time.sleep(0.06)"),
    "both cores busy, server killed": lambda: on_a_busy_computer(server_killed),
    "both cores busy, server hangs": lambda: on_a_busy_computer(server_hangs),
    "Ctrl-C": lambda: ended(signal.SIGINT),
    "SIGTERM": lambda: ended(signal.SIGTERM),
    "SIGHUP": lambda: ended(signal.SIGHUP),
    "Ctrl-C while the sound server hangs": lambda: ended(signal.SIGINT, hangs=True),
}


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--runs", type=int, default=3, help="of each fault")
    arguments = parser.parse_args()
    print(f"{machine()}; the worst of {arguments.runs} runs\n")
    print(f"{'':37}zero velocity   hears again")
    print(f"{'':37}after           (or ended) after")
    for name, fault in FAULTS.items():
        runs = [fault() for _ in range(arguments.runs)]
        zero, after = max(run.zero for run in runs), max(run.after for run in runs)
        print(f"{name:36} {zero:6.2f} s        {after:6.2f} s   {runs[0].warning}", flush=True)


if __name__ == "__main__":
    main()
