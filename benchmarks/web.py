"""Whether the beat holds while many watch the operator page.

Run `python benchmarks/web.py` (`--watchers 50 --seconds 300`). A `voz run --web` with the simulator
is driven by one page, which speaks into it and answers each state, and watched by others, some of
which read nothing. Printed are the beat, the time to a confirmed stop and to a spoken command, and
the processor time of the robot's program alone.
"""

from __future__ import annotations

import argparse
import os
import statistics
import sys
import tempfile
import threading
import time
from collections.abc import Iterator
from contextlib import ExitStack, contextmanager
from itertools import cycle, pairwise
from pathlib import Path

from machine import machine

sys.path.insert(0, str(Path(__file__).parent.parent / "tests"))

from operator_page import Page, PageRobot, heard, opened, page_robot, with_noise
from recordings import FIXTURES

SAID = ("go_forward", "go_back")
ASLEEP = 5
"""Every so many of the watchers reads nothing."""


@contextmanager
def watching(robot: PageRobot, count: int) -> Iterator[None]:
    """Let many watch for the length of a `with` block, each on a thread."""
    over = threading.Event()

    def watch(page: Page) -> None:
        while not over.is_set():
            page.socket.recv(5)

    with ExitStack() as pages:
        threads = []
        for number in range(count):
            page = pages.enter_context(opened(robot))
            if number % ASLEEP:
                threads.append(threading.Thread(target=watch, args=(page,), daemon=True))
        for thread in threads:
            thread.start()
        try:
            yield
        finally:
            over.set()
            for thread in threads:
                thread.join()


def drive(robot: PageRobot, seconds: float) -> list[float]:
    """Drive by one page, by voice and by taps; gives how long each stop took, s."""
    stops = []
    clips = (FIXTURES / "commands" / f"festival_slt__{name}.flac" for name in SAID)
    sounds = cycle([with_noise(clip, 0.2, 0.6) for clip in clips])
    until = time.monotonic() + seconds
    with opened(robot) as page:
        page.drive()
        with heard(robot, page) as ear:
            while time.monotonic() < until:
                ear.begin()
                ear.speak(next(sounds), page)
                ear.end()
                page.stay(1.0)
                begun = time.monotonic()
                assert robot.api.post("/api/stop").json()["stopped"]
                stops.append(time.monotonic() - begun)
                page.stay(0.5)
    return stops


def processor_time(process: int) -> float:
    """Of a process so far, s."""
    fields = Path(f"/proc/{process}/stat").read_text().rpartition(")")[2].split()
    return (int(fields[11]) + int(fields[12])) / os.sysconf("SC_CLK_TCK")


def report(robot: PageRobot, since: int, stops: list[float]) -> None:
    """Print how the beat held."""
    beats = [event["t"] for event in robot.robot.of("cmd_vel", since)]
    whole = sorted({round(t, 1) for t in beats})
    arrived = [a.when for a in robot.robot.arrived[since:] if a.event["type"] == "cmd_vel"]
    gaps = [late - early for early, late in pairwise(beats)]
    said = [e for e in robot.robot.of("utterance", since) if e["source"] == "browser"]
    latencies = [e["latency"] for e in said if e["obeyed"]]
    print(f"beat: {len(whole) / (beats[-1] - beats[0]):.2f} Hz, longest gap {max(gaps):.3f} s")
    print(f"events took until {arrived[-1] - arrived[0]:.1f} s for {beats[-1] - beats[0]:.1f} s")
    print(f"stop confirmed: median {statistics.median(stops):.3f} s, worst {max(stops):.3f} s")
    print(
        f"spoken commands obeyed: {len(latencies)} of {len(stops)}, "
        f"latency median {statistics.median(latencies):.2f} s, worst {max(latencies):.2f} s"
    )
    print(f"warnings: {robot.robot.warnings(since) or 'none'}")


def main() -> None:
    """Run it, and print."""
    parser = argparse.ArgumentParser()
    parser.add_argument("--watchers", type=int, default=50)
    parser.add_argument("--seconds", type=float, default=300.0)
    wanted = parser.parse_args()
    print(machine())
    with tempfile.TemporaryDirectory() as folder:
        config = Path(folder) / "alsa.conf"
        config.write_text("pcm.default { type hw card 99 }")
        environment = os.environ | {"ALSA_CONFIG_PATH": str(config)}
        for watchers in (0, wanted.watchers):
            with page_robot(environment, "--listening") as robot, watching(robot, watchers):
                process, since = robot.robot.process.pid, robot.since
                begun, used = time.monotonic(), processor_time(process)
                stops = drive(robot, wanted.seconds)
                share = (processor_time(process) - used) / (time.monotonic() - begun)
                print(f"\n{watchers} watchers and one driver, {wanted.seconds:.0f} s")
                report(robot, since, stops)
                print(f"processor time: {share:.0%} of a core")


if __name__ == "__main__":
    main()
