"""Whether a robot hears its commands above its own motors, and above all `stop`.

Run `python benchmarks/motors.py MANIFEST... --noise FILE [--snr DB]`. For each command of the
manifests a simulated robot is told to drive by a typed `go forward`. From then on its motors
sound, as loud as the ratio says beside the speaker, for as long as it moves, and stop when it does:
what is recognized decides what the microphone hears. Some seconds later the command is said. It
counts as heard in time if it takes effect, or for `stop` if the robot has halted, no later than
0.5 s after its last word; the ratio is that of the speech's active frames to the mean of the noise.
"""

from __future__ import annotations

import argparse
import random
from collections import defaultdict
from collections.abc import Sequence
from pathlib import Path
from typing import NamedTuple

import numpy as np
import numpy.typing as npt
from machine import machine, one_line_errors

import voz
from voz.api.recognizer import Recognizer
from voz.apps.evaluation.noise import speech_power
from voz.apps.evaluation.statistics import estimate
from voz.apps.evaluation.tables import estimate_text
from voz.apps.recordings.manifest import Clip, read_manifests
from voz.audio import SAMPLE_RATE
from voz.audio.sound_files import read_samples, to_int16
from voz.events import Event, Utterance
from voz.language.language_files import find_language
from voz.language.sentences.command_set import plain_commands
from voz.recognition.engine import open_stream
from voz.recognition.stream import Stream
from voz.robot.simulation.simulator import SimulatedRobot
from voz.run.sources import text_utterance
from voz.settings import Recognition, Simulator

BLOCK = 480
"""Samples that the microphone hands over at a time, 30 ms."""

DRIVES_AT = 1.0
"""When the robot is told to drive, s."""

SAID_AFTER = [1.5, 3.0]
"""How long after that the command is said, at least and at most, s."""

LISTENED = 2.0
"""How long after the command is listened on, s."""

IN_TIME = 0.5
"""How soon after its last word a command is to take effect, s."""

STILL = 0.01
"""Below this, m/s and rad/s, the motors are not heard."""

LOUDNESS = 0.05
"""Of the speech, full scale being 1."""

Floats = npt.NDArray[np.float64]


class Said(NamedTuple):
    """A command in a room that is quiet but for the robot's motors."""

    speech: Floats  # what is said in it, from the beginning to the end
    end: float  # where the last word ends, s


class Heard(NamedTuple):
    """When the robot was asked to stand still, s, and what took effect, and when."""

    halted: float | None
    obeyed: list[Utterance]


def said(clip: Path, after: list[float], rng: np.random.Generator) -> Said:
    """Put a command somewhere behind the robot's start."""
    samples = read_samples(clip)
    speech = samples / np.sqrt(speech_power(samples)) * LOUDNESS
    soonest, latest = after
    begin = round((DRIVES_AT + rng.uniform(soonest, latest)) * SAMPLE_RATE)
    room = rng.standard_normal(begin + len(speech) + round(LISTENED * SAMPLE_RATE)) * 1e-4
    room[begin : begin + len(speech)] += speech
    loud = np.flatnonzero(np.abs(speech) > 0.05 * np.abs(speech).max())
    return Said(room, (begin + int(loud[-1])) / SAMPLE_RATE)


def drive(stream: Stream, room: Floats, motors: Floats) -> Heard:
    """Let a robot drive, and hear its motors and what is said for as long as it moves."""
    obeyed: list[Utterance] = []
    halted = None

    def note(event: Event) -> None:
        if isinstance(event, Utterance) and event.obeyed and event.source != "text":
            obeyed.append(event)

    robot = SimulatedRobot(Simulator())
    driven = voz.Controller([robot.receive, note], listening=True)
    for begin in range(0, len(room) - BLOCK, BLOCK):
        now = (begin + BLOCK) / SAMPLE_RATE
        if begin / SAMPLE_RATE <= DRIVES_AT < now:
            driven.hear(text_utterance("go forward", plain_commands(["go forward"]), (), now))
        state = robot.state_at(now)
        sound = room[begin : begin + BLOCK].copy()
        if abs(state.linear) > STILL or abs(state.angular) > STILL:
            sound += motors[begin : begin + BLOCK]
        for event in stream.feed(to_int16(sound)):
            driven.hear(event)
        driven.send(now)
        if halted is None and now > DRIVES_AT + 0.1 and not driven.moving:
            halted = now
    return Heard(halted, obeyed)


def in_time(text: str, heard: Heard, end: float) -> bool:
    """Whether a command took effect, no sooner than it was said and no later than it should."""
    if text == "stop":
        return heard.halted is not None and end - 1 < heard.halted <= end + IN_TIME
    return any(u.text == text and u.t <= end + IN_TIME for u in heard.obeyed)


def tiled(noise: Floats, length: int, rng: np.random.Generator) -> Floats:
    """A stretch of a noise, from anywhere in it."""
    at = int(rng.integers(len(noise)))
    return np.resize(np.roll(noise, -at), length)


def main() -> None:
    """Print the table."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("manifests", nargs="+", type=Path)
    parser.add_argument("--noise", type=Path, required=True, help="of motors, going on")
    parser.add_argument("--snr", type=float, default=10.0, help="of the speech to it, dB")
    parser.add_argument("--most", type=int, default=100, help="of `stop`, and of the others")
    parser.add_argument("--after", nargs=2, type=float, default=SAID_AFTER, help="from, to, s")
    asked = parser.parse_args()
    noise = read_samples(asked.noise).astype(float)
    noise *= LOUDNESS / 10 ** (asked.snr / 20) / np.sqrt(np.mean(noise**2))
    recognizer = Recognizer(find_language(None), Recognition())
    rng = np.random.default_rng(0)
    found: dict[str, list[tuple[str, bool]]] = defaultdict(list)
    for clip in chosen(read_manifests(asked.manifests), asked.most):
        room = said(clip.path, asked.after, rng)
        motors = tiled(noise, len(room.speech), rng)
        heard = drive(open_stream(recognizer, "microphone"), room.speech, motors)
        name = "`stop`" if clip.text == "stop" else "other commands"
        found[f"{name} in time"].append((clip.speaker, in_time(clip.text, heard, room.end)))
        too_soon = heard.halted is not None and heard.halted < room.end - 1
        found["halted before anything was said"].append((clip.speaker, too_soon))
    when = f"said {asked.after[0]:g} to {asked.after[1]:g} s after it began to drive"
    print(f"{machine()}; {asked.noise.name} {asked.snr:g} dB below the speech, {when}\n")
    print("| | commands | share |\n|---|---|---|")
    for name, each in sorted(found.items()):
        speakers, hits = zip(*each, strict=True)
        share = estimate_text(estimate(hits, [1.0] * len(each), speakers))
        print(f"| {name} | {len(each)} | {share} |")


def chosen(clips: Sequence[Clip], most: int) -> list[Clip]:
    """Commands of people and of voices close to people: so many of `stop`, and of the others."""
    clips = [c for c in clips if c.kind == "command" and c.condition != "robotic"]
    random.Random(0).shuffle(clips)
    stops = [c for c in clips if c.text == "stop"]
    others = [c for c in clips if c.text not in ("stop", "go forward", "start speech")]
    return [*stops[:most], *others[:most]]


if __name__ == "__main__":
    with one_line_errors():
        main()
