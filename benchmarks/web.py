"""Whether the beat holds while many watch the operator page.

Run `python benchmarks/web.py` (`--watchers 50 --seconds 300`). A `voz run --web` with the simulator
is driven by one page, which speaks into it and answers each state, and watched by others, some of
which read nothing. Printed are the beat, the time to a confirmed stop and to a spoken command, and
the processor time of the robot's program alone. Before that it prints how soon the robot does what
a page's microphone hears, as `benchmarks/latency.py` does for one of the robot's own: from the last
sample of a command, of which there are `--commands 40`, to the changed `cmd_vel`.
"""

from __future__ import annotations

import argparse
import os
import random
import statistics
import sys
import tempfile
import threading
import time
from collections.abc import Iterator
from contextlib import ExitStack, contextmanager
from itertools import cycle, pairwise
from pathlib import Path

import numpy as np
from latency import FIXTURES as MANIFEST
from latency import GIVEN_UP, MOVING, UNSEEN, first_effect, spoken
from machine import machine, one_line_errors

sys.path.insert(0, str(Path(__file__).parent.parent / "tests"))

from operator_page import (
    BLOCK,
    Microphone,
    Page,
    PageRobot,
    heard,
    opened,
    page_robot,
    room_noise,
    told,
    with_noise,
)
from recordings import FIXTURES
from websockets.sync.client import ClientConnection

from voz.apps.recordings.manifest import Clip, read_manifests
from voz.audio import SAMPLE_RATE

SAID = ("go_forward", "go_back")
ASLEEP = 5
"""Every so many of the watchers reads nothing."""


@contextmanager
def watching(robot: PageRobot, count: int) -> Iterator[None]:
    """Let many watch for the length of a `with` block, each on a thread."""
    over = threading.Event()

    def watch(page: ClientConnection) -> None:
        while not over.is_set():
            page.recv(5)

    with ExitStack() as pages:
        threads = []
        for number in range(count):
            page = pages.enter_context(told(robot))
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


def latencies(robot: PageRobot, clips: list[Clip]) -> list[float | None]:
    """How long each command took, s; None for one that was not obeyed."""
    with opened(robot) as page:
        page.drive()
        with heard(robot, page) as ear:
            ear.begin()
            return [latency(robot, page, ear, clip) for clip in clips]


def latency(robot: PageRobot, page: Page, ear: Microphone, clip: Clip) -> float | None:
    """Speak a command; the time runs from when its last block is sent, as a browser does then."""
    ear.speak(room_noise(1.2), page)
    for text in ("start speech", "stop", *(["go forward"] if clip.text in MOVING else [])):
        robot.command(text, page=page.welcome["secret"]).raise_for_status()
    ear.speak(room_noise(0.3), page)
    since, sound = len(robot.robot.arrived), spoken(clip.path)
    whole = -(-len(sound) // BLOCK) * BLOCK  # the noise fills the last block up
    noise = room_noise((whole + BLOCK) / SAMPLE_RATE)
    ear.speak(noise + np.pad(sound, (0, len(noise) - len(sound))), page)
    ended = time.monotonic() - BLOCK / SAMPLE_RATE
    while time.monotonic() < ended + GIVEN_UP:
        if (at := first_effect(robot.robot.arrived, since)) is not None:
            return at - ended
        ear.speak(room_noise(2 * BLOCK / SAMPLE_RATE), page)
    return None


def print_latencies(robot: PageRobot, count: int) -> None:
    """Print how soon what a page hears takes effect."""
    clips = [c for c in read_manifests([MANIFEST]) if c.kind == "command"]
    clips = [c for c in clips if c.text not in UNSEEN and not c.speaker.startswith("espeak")]
    took = latencies(robot, random.Random(0).sample(clips, min(count, len(clips))))
    obeyed = [seconds for seconds in took if seconds is not None]
    median, most = np.percentile(obeyed, [50, 95])
    print(
        f"by a page's microphone: {len(obeyed)} of {len(took)} obeyed, "
        f"median {median:.3f} s, 95 % {most:.3f} s"
    )


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
    print(f"warnings: {', '.join(dict.fromkeys(robot.robot.warnings(since))) or 'none'}")


def main() -> None:
    """Run it, and print."""
    parser = argparse.ArgumentParser()
    parser.add_argument("--watchers", type=int, default=50)
    parser.add_argument("--seconds", type=float, default=300.0)
    parser.add_argument("--commands", type=int, default=40)
    wanted = parser.parse_args()
    print(machine())
    with tempfile.TemporaryDirectory() as folder:
        config = Path(folder) / "alsa.conf"
        config.write_text("pcm.default { type hw card 99 }")
        environment = os.environ | {"ALSA_CONFIG_PATH": str(config)}
        if wanted.commands:
            with page_robot(environment, "--listening") as robot:
                print_latencies(robot, wanted.commands)
        for watchers in (0, wanted.watchers) if wanted.seconds else ():
            with page_robot(environment, "--listening") as robot, watching(robot, watchers):
                process, since = robot.robot.process.pid, robot.since
                begun, used = time.monotonic(), processor_time(process)
                stops = drive(robot, wanted.seconds)
                share = (processor_time(process) - used) / (time.monotonic() - begun)
                print(f"\n{watchers} watchers and one driver, {wanted.seconds:.0f} s")
                report(robot, since, stops)
                print(f"processor time: {share:.0%} of a core")


if __name__ == "__main__":
    with one_line_errors():
        main()
