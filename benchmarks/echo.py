"""Whether `stop` is heard while the robot speaks, and nothing else is; and commands that interrupt.

Run `python benchmarks/echo.py MANIFEST... [--most N] [--hours H]`. Each `stop` of the manifests is
put somewhere into a reply, as loud as the speaker and 10 dB louder, by several loudspeakers, voices
and delays; the speakers are those from whom the network learned nothing and by whom nothing was
chosen. Then H hours of replies alone are listened to. `--interrupt` does the same with other
commands and `barge_in`; `--page` with a page that replies; `--softer` prints by how much the echo
of replies alone becomes softer.
"""

from __future__ import annotations

import argparse
import random
import time
from collections import defaultdict
from collections.abc import Sequence
from functools import partial
from pathlib import Path

import numpy as np
from loudspeakers import PATHS, ROOM_NOISE, EchoPath, Floats, Played, loud_power, reply, speech
from machine import machine, one_line_errors
from mix_rooms import is_held_back

from voz.api.recognizer import Recognizer
from voz.apps.evaluation.statistics import alarm_rate
from voz.apps.recordings.manifest import Clip, read_manifests
from voz.apps.web.page_sound import PLAYBACK_DELAY
from voz.audio import SAMPLE_RATE
from voz.audio.echo import EchoCanceller
from voz.audio.echo_alignment import MAX_ECHO_DELAY
from voz.config import default_commands
from voz.events import Partial, Utterance
from voz.hearing.half_duplex import (
    CLEANED_END,
    CLEANED_SAMPLES,
    ECHO_FIT_SAMPLES,
    HalfDuplex,
)
from voz.language.language_files import find_language
from voz.settings import Recognition

LEVELS = (0.0, 10.0)
"""The reply over the speaker, dB."""

REPLIES = (
    ("bep bep. I am listening you", "kal_diphone"),
    ("bep bep. I stop listening", "kal_diphone"),
    ("the battery is at 47 percent, and it is 10 past 8", "cmu_us_slt_arctic_hts"),
    ("I am going forward, then I turn left, and I go back", "kal_diphone"),
    ("somebody put the red box on top of the second table", "espeak-ng:en-us"),
    ("start speech. speed up. slow down. point beer. fold arm", "ked_diphone"),
    ("please step aside, I pass the shop and the post office", "espeak-ng:en-gb+f3"),
)
"""Texts and voices."""

SPEECH_POWER = 2000.0**2
"""Of a speaker, where there is none."""

LOUD_POWER = 10 * SPEECH_POWER
"""Of a reply 10 dB louder."""

PAUSE = 3 * SAMPLE_RATE // 2
"""Before and after a reply."""

PAGE_PATH = EchoPath("page", PATHS[1].loudspeaker, late=0.3)
"""A page begins to play when the robot has answered, on a wireless loudspeaker."""

PAGE_LOUDER = (None, -10.0, 0.0, 10.0)
"""The reply of a page over the speaker, dB; None for headphones."""

OFFSETS = np.arange(0.0, 3.1, 0.5)
"""Command after the beginning of the reply, s."""

BLOCK = 480


def heard(recognizer: Recognizer, sound: Floats, played: Played | None) -> list[str]:
    """What is halted for or obeyed: with the half duplex, or by the plain recognizer."""
    samples = np.clip(np.rint(sound), -32768, 32767).astype(np.int16)
    duplex = HalfDuplex(recognizer, played, ("stop",))
    texts = []
    for at in range(0, len(samples) - BLOCK, BLOCK):
        now = (at + BLOCK) / SAMPLE_RATE
        if played:
            played.now = now
        texts += [e.text for e in duplex.feed(samples[at : at + BLOCK], now) if counts(e)]
    return texts


def counts(event: Utterance | Partial) -> bool:
    return isinstance(event, Partial) or (event.accepted and not event.ignored)


def noise(length: int, rng: np.random.Generator) -> Floats:
    return np.asarray(rng.normal(0, ROOM_NOISE, length))


def add_at(place: int, said: Floats, sound: Floats) -> Floats:
    """A copy of the sound with what was said from a place on."""
    said = said[: len(sound) - place]
    mixed = sound.copy()
    mixed[place : place + len(said)] += said
    whole: Floats = mixed
    return whole


def played_by(path: EchoPath, sound: Floats) -> Floats:
    """A reply with silence around it, which a loudspeaker may have played before."""
    before = [sound, np.zeros(PAUSE)] if path.spoken_before else []
    return np.concatenate([np.zeros(PAUSE), *before, sound, np.zeros(PAUSE)])


class Tally:
    """What share of the commands is heard, by loudspeaker and level, and by reply."""

    def __init__(self) -> None:
        self.found: dict[tuple[str, float], list[bool]] = defaultdict(list)

    def count(self, rows: Sequence[str], level: float, is_heard: bool) -> None:
        """Count a command in some rows."""
        for row in rows:
            self.found[row, level].append(is_heard)

    def print(self, what: str) -> None:
        """Print the table."""
        print(f"\n| {what} | " + " | ".join(f"{level:+g} dB" for level in LEVELS) + " |")
        print("|---" * (len(LEVELS) + 1) + "|")
        for row in dict.fromkeys(row for row, _ in self.found):
            shares = [np.mean(self.found[row, level]) for level in LEVELS]
            print(f"| {row} | " + " | ".join(f"{share:.3f}" for share in shares) + " |", flush=True)


def print_said(
    recognizer: Recognizer, clips: Sequence[Clip], rng: np.random.Generator, interrupt: bool
) -> None:
    """Print which commands are heard that are said into a reply."""
    tally = Tally()
    for path in PATHS:
        for number, clip in enumerate(clips):
            text, voice = REPLIES[number % len(REPLIES)]
            if interrupt and set(text.split()) & set(clip.text.split()):
                continue
            sound = reply(text, voice)
            played = played_by(path, sound)
            said = speech(clip.path)
            begin = len(played) - PAUSE - len(sound)
            at = begin + int(rng.uniform(0, 1) * max(1, len(sound) - len(said)))
            echo = path.echo(played, loud_power(said), rng)
            for level in LEVELS:
                both = add_at(at, said, echo * 10 ** (level / 20) + noise(len(echo), rng))
                end = (begin + len(sound)) / SAMPLE_RATE + path.late
                robot = Played(played, end, text if interrupt else None)
                is_heard = clip.text in heard(recognizer, both, robot)
                rows = ["all", path.name, f"`{text}` ({voice})"]
                tally.count(rows, level, is_heard)
    tally.print("heard of those said into a reply")
    alone = []
    for clip in clips:
        said = np.pad(speech(clip.path), PAUSE)
        alone.append(clip.text in heard(recognizer, said + noise(len(said), rng), None))
    print(f"\nWithout a reply: {np.mean(alone):.3f}")


def print_alone(
    recognizer: Recognizer, hours: float, rng: np.random.Generator, interrupt: bool
) -> None:
    """Print what replies raise where nobody says anything."""
    listened: dict[str, float] = defaultdict(float)
    raised: dict[str, list[str]] = defaultdict(list)
    number = 0
    while listened["all"] < hours:
        text, voice = REPLIES[number % len(REPLIES)]
        path = PATHS[number // len(REPLIES) % len(PATHS)]
        sound = reply(text, voice)
        played = np.pad(sound, PAUSE)
        level = LEVELS[number % len(LEVELS)]
        echo = path.echo(played, SPEECH_POWER * 10 ** (level / 10), rng) + noise(len(played), rng)
        end = (PAUSE + len(sound)) / SAMPLE_RATE + path.late
        robot = Played(played, end, text if interrupt else None)
        found = heard(recognizer, echo, robot)
        for row in ("all", path.name, f"`{text}` ({voice})"):
            listened[row] += len(sound) / SAMPLE_RATE / 3600
            raised[row] += found
        number += 1
    print("\n| replies alone | hours | raised | an hour | what |")
    print("|---|---|---|---|---|")
    for row, so_long in listened.items():
        rate = alarm_rate(len(raised[row]), so_long)
        each, what = rate.per_hour, ", ".join(sorted(set(raised[row])))
        interval = f"{each.value:.2f} ({each.low:.2f} to {each.high:.2f})"
        print(f"| {row} | {so_long:.2f} | {rate.alarms} | {interval} | {what} |")


def print_page(recognizer: Recognizer, clips: list[Clip], rng: np.random.Generator) -> None:
    """Print which commands are heard while a page replies, and what replies alone raise."""
    print("\nA command that begins so long after the reply of a page, heard by its microphone:")
    print("| reply over the speaker | known | " + " | ".join(f"{o:g} s" for o in OFFSETS), end="")
    print(" | replies alone obeyed |")
    print("|---" * (len(OFFSETS) + 3) + "|")
    for louder in PAGE_LOUDER:
        found: dict[bool, list[bool]] = {False: [], True: []}
        raised = {False: 0, True: 0}
        for number, clip in enumerate(clips):
            text = default_commands().replies[number % 2]
            sound = reply(text, "kal_diphone")
            played = np.pad(sound, (PAUSE, 5 * SAMPLE_RATE))
            said = speech(clip.path)
            echo = noise(len(played), rng)
            if louder is not None:
                echo += PAGE_PATH.echo(played, loud_power(said) * 10 ** (louder / 10), rng)
            end = (PAUSE + len(sound)) / SAMPLE_RATE + PLAYBACK_DELAY
            at = PAUSE + round(OFFSETS[number % len(OFFSETS)] * SAMPLE_RATE)
            both = add_at(at, said, echo)
            for known in (False, True):
                page = partial(Played, played, end, text if known else None)
                found[known].append(clip.text in heard(recognizer, both, page()))
                raised[known] += bool(heard(recognizer, echo, page()))
        for known, values in found.items():
            shares = [np.mean(values[n :: len(OFFSETS)]) for n in range(len(OFFSETS))]
            cells = " | ".join(f"{share:.2f}" for share in shares)
            name = "headphones" if louder is None else f"{louder:+g} dB"
            print(f"| {name} | {'yes' if known else 'no'} | {cells} | ", end="")
            print(f"{raised[known]} of {len(clips)} |", flush=True)


def print_softer(rng: np.random.Generator) -> None:
    """Print by how much the echo of replies becomes softer, and what that costs."""
    print("\n| loudspeaker | the echo of replies alone becomes softer by | CPU, each time |")
    print("|---|---|---|")
    for path in PATHS:
        heard, left, times, seconds = np.sum([softened(path, reply(*r), rng) for r in REPLIES], 0)
        softer, cost = 10 * np.log10(heard / left), 1000 * seconds / times
        print(f"| {path.name} | {softer:.1f} dB | {cost:.0f} ms |", flush=True)


def softened(path: EchoPath, sound: Floats, rng: np.random.Generator) -> tuple[float, ...]:
    """The energy of a reply's echo, before and after; how often it is cleaned, and CPU time, s."""
    played = np.pad(played_by(path, sound), (ECHO_FIT_SAMPLES - PAUSE, 0))
    echo = path.echo(played, LOUD_POWER, rng) + noise(len(played), rng)
    begin = len(played) - PAUSE - len(sound)
    samples, robot, canceller = np.rint(echo).astype(np.int16), Played(played, 0.0), EchoCanceller()
    heard = left = seconds = 0.0
    ends = range(ECHO_FIT_SAMPLES, len(samples), CLEANED_SAMPLES)
    for end in ends:
        robot.now = end / SAMPLE_RATE
        source, _ = robot.recent((ECHO_FIT_SAMPLES + MAX_ECHO_DELAY) / SAMPLE_RATE)
        begun = time.process_time()
        cleaned = canceller.clean(samples[end - ECHO_FIT_SAMPLES : end], source)
        seconds += time.process_time() - begun
        part = cleaned.cut(slice(CLEANED_END - CLEANED_SAMPLES, CLEANED_END))
        if end > begin:
            heard += float(np.sum((part.samples + part.echo) ** 2))
            left += float(np.sum(part.samples.astype(float) ** 2))
    return heard, left, len(ends), seconds


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("manifests", nargs="+", type=Path)
    parser.add_argument("--most", type=int, default=60, help="recordings")
    parser.add_argument("--hours", type=float, default=0.1, help="of replies alone")
    parser.add_argument("--seed", type=int, default=0, help="of rooms, noise and places")
    parser.add_argument("--interrupt", action="store_true", help="other commands, with barge_in")
    parser.add_argument("--page", action="store_true", help="a page that replies")
    parser.add_argument("--softer", action="store_true", help="what is left of the echo alone")
    arguments = parser.parse_args()
    rng = np.random.default_rng(arguments.seed)
    if arguments.softer:
        print(machine())
        print_softer(rng)
        return
    every = [c for c in read_manifests(arguments.manifests) if c.kind == "command"]
    every = [c for c in every if c.condition != "robotic" and is_held_back(c.speaker)]
    if arguments.interrupt or arguments.page:
        clips = [c for c in every if "stop" not in c.text and c.text != "start speech"]
    else:
        clips = [c for c in every if c.text == "stop"]
    clips = random.Random(0).sample(clips, min(len(clips), arguments.most))
    recognizer = Recognizer(find_language(None), Recognition())
    print(f"{machine()}; {len(clips)} clips")
    if arguments.page:
        print_page(recognizer, clips, rng)
    else:
        if clips:
            print_said(recognizer, clips, rng, arguments.interrupt)
        if arguments.hours:
            print_alone(recognizer, arguments.hours, rng, arguments.interrupt)


if __name__ == "__main__":
    with one_line_errors():
        main()
