"""How soon a reply is heard, and how soon a stopped sound is not.

Run `python benchmarks/replies.py`. A PulseAudio server of its own has a loudspeaker without
hardware, and what reaches that is recorded: the times hold the recorder's delay of some 10 ms too.
The robot's program is a process of its own, with and without festival's work of an earlier run.
"""

from __future__ import annotations

import json
import os
import subprocess
import sys
import tempfile
import threading
import time
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt
from machine import machine

sys.path.insert(0, str(Path(__file__).parent.parent / "tests"))

from pulseaudio import sound_server

from voz.audio.playback import AUDIBLE_AMPLITUDE, PLAYBACK_RATE
from voz.config import default_commands
from voz.speech.reply_speaker import ReplySpeaker
from voz.speech.sound_client import SoundClient, mixer_of

RECORD = "parecord --device=speaker.monitor --rate=16000 --channels=1 --format=s16le --raw"
STARTS, REPLIES_SAID, STOPS = 5, 41, 40
PAUSES = (0.6, 2.6)
"""Seconds after a reply: after the first the loudspeaker is still open, after the second not."""

STARTING = 3.0
"""Seconds from the start of the program to the first command: nobody speaks sooner."""


class Recorder:
    """Keeps what is heard, with when it arrived."""

    def __init__(self, environment: dict[str, str]) -> None:
        command = [*RECORD.split(), "--latency-msec=10"]
        self._process = subprocess.Popen(command, env=environment, stdout=subprocess.PIPE)
        self.blocks: list[tuple[float, npt.NDArray[np.int16]]] = []
        threading.Thread(target=self._read, daemon=True).start()

    def _read(self) -> None:
        assert self._process.stdout is not None
        while data := os.read(self._process.stdout.fileno(), 1 << 16):
            self.blocks.append((time.monotonic(), np.frombuffer(data, np.int16)))

    def first(self, after: float, audible: bool) -> float:
        """When the first block that is audible, or silent, came after a time, s since then."""
        for arrived, block in self.blocks:
            if (
                arrived > after
                and bool((np.abs(block[-32:]) > AUDIBLE_AMPLITUDE * 32768).any()) is audible
            ):
                return arrived - after
        return float("nan")

    def close(self) -> None:
        """Record no more."""
        self._process.terminate()
        self._process.wait()


def robot(wait: float, rounds: int) -> None:
    """Say replies; print when each was asked for."""
    replies = default_commands().replies
    with ReplySpeaker("kal_diphone", replies) as speaker:
        time.sleep(wait)
        for number in range(rounds):
            asked = time.monotonic()
            speaker.say(replies[number % 2])
            print(json.dumps(asked), flush=True)
            time.sleep(0.5)
            while speaker.mixer.busy_until() > time.monotonic():
                time.sleep(0.05)
            time.sleep(PAUSES[number % 2])


def stopping(rounds: int) -> None:
    """Start and stop a sound; print when it was to stop, and until when it is said to be heard."""
    client = SoundClient()
    tone = 0.5 * np.sin(2 * np.pi * 440 * np.arange(PLAYBACK_RATE) / PLAYBACK_RATE)
    for number in range(rounds):
        source = mixer_of(client).play(tone.astype(np.float32), repeats=True)
        time.sleep(1 + 0.0137 * number)
        asked = time.monotonic()
        mixer_of(client).stop(source)
        mixer_of(client).wait(source)
        print(json.dumps([asked, mixer_of(client).busy_until()]), flush=True)
        time.sleep(0.5)
    client.close()


@contextmanager
def recording() -> Iterator[tuple[dict[str, str], Recorder]]:
    with sound_server() as (environment, _), tempfile.TemporaryDirectory() as cache:
        recorder = Recorder(environment)
        try:
            yield environment | {"XDG_CACHE_HOME": cache}, recorder
        finally:
            recorder.close()


def asked_in(environment: dict[str, str], *arguments: object) -> list[Any]:
    command = [sys.executable, __file__, *map(str, arguments)]
    done = subprocess.run(command, env=environment, stdout=subprocess.PIPE, check=True)
    time.sleep(0.2)
    return [json.loads(line) for line in done.stdout.splitlines()]


def row(name: str, seconds: list[float]) -> None:
    median, most = np.percentile(1000 * np.array(seconds), [50, 95])
    print(f"| {name} | {len(seconds)} | {median:.0f} ms | {most:.0f} ms |", flush=True)


def main() -> None:
    print(f"{machine()}\n")
    print("| from | times | median | 95 % |")
    print("|---|---|---|---|")
    at_once, prepared = [], []
    for _ in range(STARTS):
        with recording() as (environment, recorder):
            at_once += [recorder.first(t, True) for t in asked_in(environment, "robot", 0, 1)]
        with recording() as (environment, recorder):
            asked = asked_in(environment, "robot", STARTING, 1)
            prepared += [recorder.first(t, True) for t in asked]
    row("the program's first start, festival and all, to a reply", at_once)
    row(f"a command {STARTING:g} s after the first start to its reply", prepared)
    with recording() as (environment, recorder):
        asked = asked_in(environment, "robot", STARTING, REPLIES_SAID)
        later = [recorder.first(t, True) for t in asked]
        stops = asked_in(environment, "stopping", STOPS)
        stopped = [recorder.first(asked, False) for asked, _ in stops]
        told = [until - asked for asked, until in stops]
    # Before every second one there was the longer pause.
    row("a later command to its reply, loudspeaker open", later[1::2])
    row("a later command to its reply, loudspeaker closed", later[2::2])
    row("stopping a sound to silence", stopped)
    row("silence later than `busy_until` told", list(np.subtract(stopped, told)))


if __name__ == "__main__":
    if len(sys.argv) == 1:
        main()
    elif sys.argv[1] == "robot":
        robot(float(sys.argv[2]), int(sys.argv[3]))
    else:
        stopping(int(sys.argv[2]))
