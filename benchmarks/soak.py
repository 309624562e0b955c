"""Whether `voz run` stays as it is when it runs for long.

Run `python benchmarks/soak.py [--minutes N]`. The recorded fixtures, commands and near-misses, are
spoken in real time and in noise into a microphone without hardware, again and again, and `voz run`
listens. Memory and CPU are those that Linux counts for its process; the beat is that of `cmd_vel`,
without those that are sent at once because something was heard.
"""

from __future__ import annotations

import argparse
import os
import random
import re
import subprocess
import sys
import tempfile
import time
from collections import Counter
from itertools import pairwise
from pathlib import Path

import numpy as np
import soundfile
from machine import machine, one_line_errors

sys.path.insert(0, str(Path(__file__).parent.parent / "tests"))

from live_robot import LiveRobot, live_robot, speak, velocity
from pulseaudio import sound_server

from voz.apps.evaluation.noise import mix
from voz.apps.recordings.manifest import Clip, read_manifest
from voz.audio import SAMPLE_RATE, Samples
from voz.audio.sound_files import read_samples

FIXTURES = Path(__file__).parent.parent / "audio_fixtures" / "manifest.tsv"

BEFORE, AFTER = 0.5, 1.5
"""Seconds of noise around each clip; after the second it is settled what was heard."""

QUIET = 30.0
"""Seconds at the beginning in which nobody speaks."""

ROOM = 30
"""The noise of a quiet room meanwhile, root mean square."""

LOUDER = 20.0
"""By so much the speech is louder than the noise, dB."""

WARMING_UP = 5.0
"""Minutes, or a third of the run if that is less, after which memory should not grow any more.

The decoder's tables grow with the longest and noisiest stretch of sound so far.
"""


class Usage:
    """What a process takes: its memory, kB, by the time of day, and its CPU."""

    def __init__(self, process: int) -> None:
        self._process = Path("/proc") / str(process)
        self.begun = time.monotonic()
        self.first_cpu = self._cpu()
        self.memory: list[tuple[float, int]] = []

    def look(self) -> None:
        """Note the memory."""
        status = (self._process / "status").read_text()
        kilobytes = int(re.findall(r"^VmRSS:\s+(\d+)", status, re.MULTILINE)[0])
        self.memory.append((time.monotonic() - self.begun, kilobytes))

    def cpu_share(self) -> float:
        """The part of a core that it has taken so far."""
        return (self._cpu() - self.first_cpu) / (time.monotonic() - self.begun)

    def growth(self, warm: float) -> tuple[float, float, float]:
        """Memory when it is warm, at the end, and the trend in between as MB an hour."""
        later = np.array([sample for sample in self.memory if sample[0] >= warm])
        tenth = max(1, len(later) // 10)
        slope = np.polyfit(later[:, 0], later[:, 1], 1)[0] if len(later) > 2 else np.nan
        first, last = np.median(later[:tenth, 1]), np.median(later[-tenth:, 1])
        return float(first / 1024), float(last / 1024), float(slope * 3600 / 1024)

    def _cpu(self) -> float:
        fields = (self._process / "stat").read_text().rpartition(")")[2].split()
        return (int(fields[11]) + int(fields[12])) / os.sysconf("SC_CLK_TCK")


def idle_share(robot: LiveRobot, environment: dict[str, str]) -> float:
    """The part of a core that it takes while nobody speaks."""
    noise = np.random.default_rng(0).normal(0, ROOM, int(QUIET * SAMPLE_RATE))
    with tempfile.TemporaryDirectory() as folder:
        wav = Path(folder) / "room.wav"
        soundfile.write(wav, noise.astype(np.int16), SAMPLE_RATE)
        # Not by `speak`, whose haste wakes the listener six times as often as a microphone does.
        playing = ["paplay", "--device=mic", str(wav)]
        usage = Usage(robot.process.pid)
        subprocess.run(playing, env=environment, check=True)
        return usage.cpu_share()


def in_noise(clip: Clip, rng: np.random.Generator) -> Samples:
    """A clip in noise that falls by 3 dB an octave, as that of rooms does."""
    speech = read_samples(clip.path)
    around = [(int(BEFORE * SAMPLE_RATE), int(AFTER * SAMPLE_RATE))]
    speech = np.pad(speech, around)
    spectrum = np.fft.rfft(rng.standard_normal(len(speech)))
    pink = np.fft.irfft(spectrum / np.sqrt(np.arange(len(spectrum)) + 1), len(speech))
    return mix(speech, np.rint(3000 * pink / pink.std()).astype(np.int16), LOUDER)


def soak(
    robot: LiveRobot, environment: dict[str, str], minutes: float, usage: Usage
) -> Counter[str]:
    """Speak until the time is over; gives how many were obeyed, missed and so on."""
    rng = np.random.default_rng(0)
    clips = [c for c in read_manifest(FIXTURES) if c.kind in ("command", "near-miss")]
    counts: Counter[str] = Counter()
    with tempfile.TemporaryDirectory() as folder:
        wav = Path(folder) / "clip.wav"
        while True:
            for clip in random.Random(len(usage.memory)).sample(clips, len(clips)):
                if time.monotonic() - usage.begun > 60 * minutes:
                    return counts
                soundfile.write(wav, in_noise(clip, rng), SAMPLE_RATE)
                since = len(robot.arrived)
                speak(environment, wav)
                heard = [e["text"] for e in robot.of("utterance", since) if e["obeyed"]]
                counts[clip.kind] += 1
                counts[f"{clip.kind} obeyed"] += clip.text in heard
                counts[f"{clip.kind} taken for another"] += any(t != clip.text for t in heard)
                usage.look()


def beat(robot: LiveRobot) -> tuple[float, float, float]:
    """How often `cmd_vel` was sent, Hz; how far off for 95 % and at most, ms."""
    *sent, _ = robot.of("cmd_vel")  # the last one is sent when the run ends
    steady = [now["t"] for last, now in pairwise(sent) if velocity(last) == velocity(now)]
    times = np.array(steady)
    off = 1000 * np.abs(times - np.round(times * 10) / 10)
    rate = (len(times) - 1) / (times[-1] - times[0])
    return float(rate), float(np.percentile(off, 95)), float(off.max())


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--minutes", type=float, default=30)
    minutes = parser.parse_args().minutes
    with sound_server() as (environment, _), live_robot(environment, "--listening") as robot:
        idle = idle_share(robot, environment)
        usage = Usage(robot.process.pid)
        counts = soak(robot, environment, minutes, usage)
        share = usage.cpu_share()
        robot.end()
    warm = 60 * min(WARMING_UP, minutes / 3)
    first, last, trend = usage.growth(warm)
    rate, off, most = beat(robot)
    lost = [float(w.split()[0]) for w in robot.warnings() if "of sound were lost" in w]
    others = Counter(w for w in robot.warnings() if "of sound were lost" not in w)
    print(f"{machine()}; {minutes:g} minutes\n")
    print(
        f"memory            {first:.1f} MB after {warm / 60:.1f} minutes, {last:.1f} MB at the end"
    )
    print(f"  trend           {trend:+.2f} MB an hour")
    print(f"CPU               {100 * share:.1f} % of a core")
    print(f"  nobody speaks   {100 * idle:.1f} %")
    print(f"sound lost        {sum(lost):.2f} s")
    print(f"beat              {rate:.3f} Hz, 95 % within {off:.1f} ms, all within {most:.1f} ms")
    print(f"commands obeyed   {counts['command obeyed']} of {counts['command']}")
    print(f"  taken for another {counts['command taken for another']}")
    print(
        f"near-misses       {counts['near-miss']}, let through "
        f"{counts['near-miss taken for another'] + counts['near-miss obeyed']}"
    )
    for warning, times in others.items():
        print(f"warning           {times} times: {warning}")


if __name__ == "__main__":
    with one_line_errors():
        main()
