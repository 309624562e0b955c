"""How soon the robot does what it is told, from the last sample of a spoken command.

Run `python benchmarks/latency.py [MANIFEST...] [--most N]`. A PulseAudio server of its own has a
microphone without hardware; the clips, with the silence after the last word cut off, are played
into it, and `voz run` listens. The time runs from the end of the playback to the event that the
command causes: a changed `cmd_vel`, or `selected_object`. Each clip is heard twice, by a robot that
decides early and by one that waits for the end of the speech.

`--noise FILE --snr DB` lets a sound go on all the time, so far below the speakers, and
`--under "systemd-run --user --scope -p CPUQuota=25%"` holds the robot's program, and that alone, to
a quarter of a core.
"""

from __future__ import annotations

import argparse
import json
import random
import shlex
import subprocess
import sys
import tempfile
import threading
import time
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import numpy as np
import soundfile
from machine import machine, one_line_errors

sys.path.insert(0, str(Path(__file__).parent.parent / "tests"))

from pulseaudio import playing_on, sound_server

from voz.apps.evaluation.noise import speech_power
from voz.apps.recordings.manifest import Clip, read_manifests
from voz.audio import SAMPLE_RATE, Samples
from voz.audio.sound_files import read_samples, to_int16

FIXTURES = Path(__file__).parent.parent / "audio_fixtures" / "manifest.tsv"

MOVING = ("stop", "stop speech", "speed up", "slow down")
"""Commands that are seen only if the robot drives."""

UNSEEN = ("start speech",)
"""What has no effect on a robot that listens already."""

EARLY = "early_decision = 0.06"
LATE = "early_decision = 1.0"

LOUDNESS = 1600.0
"""Of the speech, where 32768 is full scale."""

GIVEN_UP = 2.5
"""Seconds after which a command was not obeyed."""


class Robot:
    """A `voz run` and its events, each with when it came."""

    def __init__(self, environment: dict[str, str], setting: str, under: str) -> None:
        self._folder = tempfile.TemporaryDirectory()
        config = Path(self._folder.name) / "voz.toml"
        config.write_text(f"[recognition]\n{setting}\n")
        command = f"-m voz run --no-sound --listening --events - --config {config}"
        self._process = subprocess.Popen(
            [*shlex.split(under), sys.executable, *command.split()],
            env=environment,
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            text=True,
        )
        self.events: list[tuple[float, dict[str, Any]]] = []
        threading.Thread(target=self._read, daemon=True).start()

    def _read(self) -> None:
        assert self._process.stdout is not None
        for line in self._process.stdout:
            self.events.append((time.monotonic(), json.loads(line)))

    def check(self) -> None:
        """End if the program has ended."""
        if self._process.poll() is not None:
            sys.exit(f"voz ended with exit code {self._process.returncode}")

    def type(self, line: str) -> None:
        """Type a command."""
        assert self._process.stdin is not None
        self._process.stdin.write(f"{line}\n")
        self._process.stdin.flush()

    def effect(self, since: int) -> float | None:
        """When the first event came that a command causes."""
        return first_effect(self.events, since)

    def close(self) -> None:
        """End the program."""
        self._process.terminate()
        self._process.wait(10)
        self._folder.cleanup()


def first_effect(events: Sequence[tuple[float, dict[str, Any]]], since: int) -> float | None:
    """When the first event came that a command causes, of those after the first `since`."""
    before = next(v for _, event in reversed(events[:since]) if (v := velocity(event)))
    for arrived, event in events[since:]:
        if event["type"] == "selected_object":
            return arrived
        if event["type"] == "cmd_vel" and velocity(event) != before:
            return arrived
    return None


def velocity(event: dict[str, Any]) -> tuple[float, float] | None:
    return (event["linear"], event["angular"]) if event["type"] == "cmd_vel" else None


@contextmanager
def robots(environment: dict[str, str], setting: str, under: str) -> Iterator[Robot]:
    robot = Robot(environment, setting, under)
    try:
        while len(robot.events) < 10:
            robot.check()
            time.sleep(0.1)
        yield robot
    finally:
        robot.close()


def spoken(path: Path) -> Samples:
    """A clip up to its last word, all as loud."""
    samples = read_samples(path)
    loud = np.flatnonzero(np.abs(samples) > 0.03 * np.abs(samples).max())
    return as_loud(samples[: loud[-1] + 1], LOUDNESS / speech_power(samples) ** 0.5)


def as_loud(samples: Samples, times: float) -> Samples:
    return to_int16(samples * (times / 32768))


@contextmanager
def going_on(environment: dict[str, str], noise: Path | None, snr: float) -> Iterator[None]:
    """Let the microphone hear a sound all the time, so many dB below the speakers."""
    if noise is None:
        yield
        return
    samples = read_samples(noise)
    mean = float(np.mean(samples.astype(float) ** 2)) ** 0.5
    raw = Path(environment["HOME"]) / "noise.raw"
    raw.write_bytes(as_loud(samples, LOUDNESS / 10 ** (snr / 20) / mean).tobytes())
    with playing_on(environment, raw):
        time.sleep(5)  # until it is known
        yield


def measure(robot: Robot, environment: dict[str, str], path: Path, text: str) -> float | None:
    time.sleep(1.2)  # nothing is said just before, and the last one is settled
    robot.type("start speech")  # the last one may have been `stop speech`
    robot.type("stop")
    if text in MOVING:
        robot.type("go forward")
    time.sleep(0.2)
    while robot.events[-1][1]["type"] != "cmd_vel":
        time.sleep(0.01)
    since = len(robot.events)
    subprocess.run(
        ["paplay", "--device=mic", "--latency-msec=20", str(path)], env=environment, check=True
    )
    ended = time.monotonic()
    while time.monotonic() < ended + GIVEN_UP:
        if (arrived := robot.effect(since)) is not None:
            return arrived - ended
        time.sleep(0.005)
    return None


def beat(robot: Robot) -> tuple[float, float]:
    """How often `cmd_vel` was sent, Hz, and by how much a beat is off for 95 %, ms."""
    times = np.array([e["t"] for _, e in robot.events if e["type"] == "cmd_vel"])
    off = np.abs(times - np.round(times * 10) / 10)
    on_beat = times[off < 0.03]  # else it is one that was sent at once
    rate = (round(on_beat[-1] * 10) - round(on_beat[0] * 10)) / (on_beat[-1] - on_beat[0])
    return float(rate), float(1000 * np.percentile(off[off < 0.03], 95))


def print_times(name: str, found: list[tuple[Clip, float | None]]) -> None:
    """Print what each command took, the speakers of each condition, and all."""
    groups: dict[str, list[float | None]] = {}
    for key in ("text", "condition"):
        for clip, took in sorted(found, key=lambda one: getattr(one[0], key)):
            groups.setdefault(getattr(clip, key), []).append(took)
    groups["all"] = [took for _, took in found]
    print(f"decided {name:14} obeyed        median    95 %")
    for group, times in groups.items():
        heard = [t for t in times if t is not None]
        median, most = np.percentile(heard, [50, 95]) if heard else (np.nan, np.nan)
        print(f"  {group:20} {len(heard):4} of {len(times):<4} {median:6.3f} s {most:6.3f} s")


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("manifests", nargs="*", type=Path, default=[FIXTURES])
    parser.add_argument("--most", type=int, default=60, help="how many clips, drawn at random")
    parser.add_argument("--conditions", nargs="*", help="only these, as us gb accent")
    parser.add_argument("--noise", type=Path, help="a sound that goes on all the time")
    parser.add_argument("--snr", type=float, default=15.0, help="of the speech to it, dB")
    parser.add_argument("--under", default="", help="a command that runs the robot's program")
    arguments = parser.parse_args()
    clips = [c for c in read_manifests(arguments.manifests) if c.kind == "command"]
    clips = [c for c in clips if c.text not in UNSEEN and not c.speaker.startswith("espeak")]
    if arguments.conditions:
        clips = [c for c in clips if c.condition in arguments.conditions]
    clips = random.Random(0).sample(clips, min(len(clips), arguments.most))
    print(f"{machine()}; {len(clips)} clips\n")
    with sound_server() as (environment, _), tempfile.TemporaryDirectory() as folder:
        for name, setting in (("early", EARLY), ("at the end", LATE)):
            found: list[tuple[Clip, float | None]] = []
            with (
                going_on(environment, arguments.noise, arguments.snr),
                robots(environment, setting, arguments.under) as robot,
            ):
                for clip in clips:
                    wav = Path(folder) / "clip.wav"
                    soundfile.write(wav, spoken(clip.path), SAMPLE_RATE)
                    took = measure(robot, environment, wav, clip.text)
                    found.append((clip, took))
                rate, off = beat(robot)
            print_times(name, found)
            print(f"  the beat: {rate:.3f} Hz, 95 % within {off:.1f} ms\n", flush=True)


if __name__ == "__main__":
    with one_line_errors():
        main()
