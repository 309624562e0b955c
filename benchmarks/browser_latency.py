"""How soon the robot does what is said into a browser, beside its own microphone.

Run `python benchmarks/browser_latency.py [--most N]` on a machine that does nothing else. A
PulseAudio server of its own has a microphone without hardware; the clips, with the silence after
the last word cut off, are played into it as in `benchmarks/latency.py`. `voz run` listens to it by
itself, then a real Chromium does, on the operator page: hands-free, and with the button held while
somebody speaks. The time runs from the end of the playback to the event that the command causes.
Behind it is what the robot knows of it: from the end of the last word in the sound that it got to
its decision; the rest is the way of the sound.
"""

from __future__ import annotations

import argparse
import random
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import NamedTuple

import numpy as np
import soundfile
from latency import FIXTURES, GIVEN_UP, MOVING, UNSEEN, first_effect, spoken
from machine import machine, one_line_errors
from playwright.sync_api import Page, sync_playwright

sys.path.insert(0, str(Path(__file__).parent.parent / "tests"))

from browser_page import drive, opened
from live_robot import LiveRobot, live_robot
from operator_page import page_robot
from pulseaudio import sound_server

from voz.apps.recordings.manifest import Clip, read_manifests
from voz.audio import SAMPLE_RATE

GOAL = 0.1
"""By so much a browser may be slower than the robot's own microphone, s."""

Hold = Callable[[bool], None]
"""Holds the button, or releases it."""


class Took(NamedTuple):
    """What a command took, s: all of it, and what the robot knows of."""

    whole: float
    known: float


def make_microphone(environment: dict[str, str]) -> None:
    """Make a microphone of the sink that is played into: Chromium takes none that is a monitor."""
    for command in (
        "load-module module-remap-source master=mic.monitor source_name=microphone",
        "set-default-source microphone",
    ):
        subprocess.run(
            ["pactl", *command.split()], env=environment, check=True, stdout=subprocess.DEVNULL
        )


@contextmanager
def own_microphone(environment: dict[str, str]) -> Iterator[tuple[LiveRobot, Hold]]:
    """A robot that listens by itself."""
    with live_robot(environment, "--listening", "--robot", "simulator") as robot:
        yield robot, lambda _: None


@contextmanager
def by_a_browser(environment: dict[str, str], hands_free: bool) -> Iterator[tuple[LiveRobot, Hold]]:
    """A robot that listens by a page in a browser, which hears the same microphone."""
    with (
        page_robot(environment, "--listening", "--device", "browser") as robot,
        sync_playwright() as playwright,
    ):
        browser = playwright.chromium.launch(
            executable_path="/usr/bin/chromium",
            args=["--no-sandbox", "--disable-gpu", "--use-fake-ui-for-media-stream"],
            env={**environment},
        )
        context = browser.new_context(permissions=["microphone"])
        page = opened(context, robot.link)
        drive(page)
        talk = page.get_by_role("button", name="Hold to talk")
        talk.wait_for()
        if hands_free:
            page.get_by_label("hands-free").check()
        else:
            talk.hover()
        yield robot.robot, (lambda _: None) if hands_free else _holding(page)
        browser.close()


def _holding(page: Page) -> Hold:
    return lambda on: page.mouse.down() if on else page.mouse.up()


def measure(
    robot: LiveRobot, hold: Hold, environment: dict[str, str], path: Path, text: str
) -> Took | None:
    """Say a clip; None if it was not obeyed."""
    time.sleep(1.2)  # nothing is said just before, and the last one is settled
    for line in ("start speech", "stop", *(["go forward"] if text in MOVING else [])):
        robot.type(line)
    time.sleep(0.2)
    while robot.arrived[-1].event["type"] != "cmd_vel":
        time.sleep(0.01)
    hold(True)
    time.sleep(0.2)
    since = len(robot.arrived)
    play = ["paplay", "--device=mic", "--latency-msec=20", str(path)]
    subprocess.run(play, env=environment, check=True)
    ended = time.monotonic()
    hold(False)
    while time.monotonic() < ended + GIVEN_UP:
        if (at := first_effect(robot.arrived, since)) is not None:
            robot.wait_for(lambda event: event.get("latency") is not None, since)
            (known, *_) = [e["latency"] for e in robot.of("utterance", since) if e.get("latency")]
            return Took(at - ended, known)
        time.sleep(0.005)
    return None


def print_times(name: str, found: list[Took | None]) -> float:
    """Print what the commands took; returns the median, s."""
    heard = np.array([one for one in found if one])
    median, most = np.percentile(heard[:, 0], [50, 95])
    known = np.median(heard[:, 1])
    print(
        f"{name:18} {len(heard):3} of {len(found):<3} {median:6.3f} s {most:6.3f} s "
        f"{known:8.3f} s {np.median(heard[:, 0] - heard[:, 1]):8.3f} s",
        flush=True,
    )
    return float(median)


def clips(most: int) -> list[Clip]:
    """Return commands of the fixtures, drawn at random."""
    found = [c for c in read_manifests([FIXTURES]) if c.kind == "command"]
    found = [c for c in found if c.text not in UNSEEN and not c.speaker.startswith("espeak")]
    return random.Random(0).sample(found, min(len(found), most))


def main() -> None:
    """Run it, and print."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--most", type=int, default=40, help="how many clips, drawn at random")
    said = clips(parser.parse_args().most)
    print(f"{machine()}; {len(said)} clips\n")
    print(f"{'ear':18} obeyed      median    95 %   its latency   the way")
    medians = []
    with sound_server() as (environment, _), tempfile.TemporaryDirectory() as folder:
        make_microphone(environment)
        for name, listening in (
            ("own microphone", own_microphone(environment)),
            ("hands-free", by_a_browser(environment, True)),
            ("hold to talk", by_a_browser(environment, False)),
        ):
            with listening as (robot, hold):
                found = []
                for clip in said:
                    wav = Path(folder) / "clip.wav"
                    soundfile.write(wav, spoken(clip.path), SAMPLE_RATE)
                    found.append(measure(robot, hold, environment, wav, clip.text))
            medians.append(print_times(name, found))
    own, *in_chromium, _ = medians
    verdict = "reached" if max(in_chromium) <= own + GOAL else "missed"
    print(f"\nthe goal, {1000 * GOAL:.0f} ms more than the own microphone, is {verdict}")


if __name__ == "__main__":
    with one_line_errors():
        main()
