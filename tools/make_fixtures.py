"""Make `audio_fixtures/` anew: recorded commands, spoken by the synthetic voices of Debian.

With `--lists` it speaks the other command lists of `audio_fixtures/lists/`, whose recordings are
too many to be kept.
"""

from __future__ import annotations

import os
from collections.abc import Iterator
from concurrent.futures import ThreadPoolExecutor
from itertools import cycle
from pathlib import Path
from typing import Annotated

import numpy as np
import soxr
import typer
from rich.console import Console
from synthesis import (
    VOICES,
    Fixture,
    Sound,
    clip,
    gain,
    low,
    normalized,
    phrase,
    power,
    shaped,
    silence,
    speak,
    with_floor,
    write,
)

from voz.audio import SAMPLE_RATE
from voz.cli.text_io import with_bar
from voz.errors import ConfigError, VozError

ROOT = Path(__file__).resolve().parent.parent
FIXTURES = ROOT / "audio_fixtures"
COMMANDS = ROOT / "lm" / "comandos_voz.txt"
LISTS = FIXTURES / "lists"
LONG_MARGIN = 0.7
PAUSES = (0.8, 1.5)
KITCHEN_SNR_DB = 15.0

NEAR_MISSES = (
    # Pieces of commands.
    *("forward", "left", "right", "speech", "fold", "up", "beer", "go", "turn", "rotate"),
    *("point", "down", "arm", "start"),
    # Begins like a command, or has one inside.
    "go forward please now",
    "go back home tomorrow",
    "go for a walk",
    "go to bed",
    "turn around",
    "turn the page",
    "turn it off",
    "turn left at the bakery",
    "stop it",
    "stop talking to me",
    "do not stop now",
    "the bus stop",
    "start the engine",
    "start again",
    "slow down a little",
    "slow cooking",
    "speed limit",
    "speak up",
    "a long speech",
    "rotate the crops",
    "point at me",
    "point of view",
    "fold the paper",
    "fold your arms",
    "a cold beer",
    "left and right",
    "back to school",
    # Everyday speech.
    "what time is it",
    "the weather is nice today",
    "my arm hurts",
    "good morning everyone",
    "where are my keys",
    "a cup of coffee",
    "thank you very much",
    "see you next week",
    "can you help me",
    "dinner is ready",
    "close the window",
    "how was your day",
    "the cat is asleep",
    "i forgot it",
    "a beautiful song",
    "who is at the door",
    "the train leaves at seven",
    "hello robot",
    "okay",
    "yes",
    "no",
    "that sounds great",
    "the phone is ringing",
)

SESSION_VOICES = ("flite_slt",)
SESSION = (
    *("start speech", "go forward", "speed up", "turn left", "stop", "rotate right", "speed up"),
    *("stop", "point beer", "fold arm", "stop speech"),
)

KITCHEN_VOICES = ("flite_rms", "festival_slt", "flite_awb")
KITCHEN = (
    *("start speech", "go back", "slow down", "turn right", "stop", "rotate left", "speed up"),
    *("stop", "point cocacola", "stop speech"),
)


def fixtures(commands: list[str]) -> Iterator[Fixture]:
    """Everything that belongs into `audio_fixtures/`.

    Args:
        commands: the robot's command list.
    """
    for voice in VOICES:
        for text in commands:
            yield clip("commands", "command", voice, text)
    for voice, text in zip(cycle(VOICES), NEAR_MISSES, strict=False):
        yield clip("near_misses", "near-miss", voice, text)

    yield Fixture(
        "long/session.wav", " | ".join(SESSION), "+".join(SESSION_VOICES), "long", session
    )
    yield Fixture(
        "long/kitchen.wav", " | ".join(KITCHEN), "+".join(KITCHEN_VOICES), "long", kitchen
    )
    yield Fixture(
        "formats/stereo_44100.wav", "go forward", "flite_slt", "format", left_channel, 44_100
    )
    yield Fixture("formats/mono_8000.wav", "stop", "flite_rms", "format", telephone, 8000)


def list_clips(name: str) -> Iterator[Fixture]:
    """Everything that is said for one of the other command lists.

    Args:
        name: of the list in `audio_fixtures/lists/`.
    """
    voices = list(VOICES)
    for voice in voices:
        for text in lines(LISTS / f"{name}.txt"):
            yield clip("commands", "command", voice, text)
    # Each near-miss by two voices: one would leave few clips, all would take minutes.
    for number, text in enumerate(lines(LISTS / f"{name}.near_misses.txt")):
        for other in (0, len(voices) // 2):
            yield clip("near_misses", "near-miss", voices[(number + other) % len(voices)], text)


def list_names() -> list[str]:
    """The names of the other command lists."""
    return sorted(path.stem for path in LISTS.glob("*.txt") if "." not in path.stem)


def lines(path: Path) -> list[str]:
    """The lines of a text file that are not empty."""
    return [line.strip() for line in path.read_text().splitlines() if line.strip()]


def session(noise: np.random.Generator) -> Sound:
    """A short story for the robot, in a quiet room."""
    return with_floor(conversation(SESSION, SESSION_VOICES, noise), noise)


def kitchen(noise: np.random.Generator) -> Sound:
    """Several people in a kitchen that is not quiet."""
    speech = conversation(KITCHEN, KITCHEN_VOICES, noise)
    background = kitchen_noise(len(speech), noise)
    said = speech[speech != 0]
    background *= power(said) / power(background) / gain(KITCHEN_SNR_DB)
    return normalized(speech + background)


def left_channel(noise: np.random.Generator) -> Sound:
    """Someone on the left of a stereo microphone: quieter in the right channel."""
    left = soxr.resample(phrase("flite_slt", "go forward"), SAMPLE_RATE, 44_100)
    return with_floor(np.column_stack([left, left * gain(-12.0)]), noise)


def telephone(noise: np.random.Generator) -> Sound:
    """A recording at the sample rate of the telephone."""
    return with_floor(soxr.resample(phrase("flite_rms", "stop"), SAMPLE_RATE, 8000), noise)


def conversation(
    texts: tuple[str, ...], voices: tuple[str, ...], noise: np.random.Generator
) -> Sound:
    """Phrases one after the other, by voices that take turns, with pauses between them."""
    pieces = [silence(LONG_MARGIN)]
    for voice, text in zip(cycle(voices), texts, strict=False):
        pieces += [speak(voice, text), silence(noise.uniform(*PAUSES))]
    return np.concatenate([*pieces[:-1], silence(LONG_MARGIN)])


def kitchen_noise(length: int, noise: np.random.Generator) -> Sound:
    """A refrigerator, a fan, a tap that runs for a while, and dishes."""
    time = np.arange(length) / SAMPLE_RATE
    hum = shaped(length, noise, low)
    fan = sum(np.sin(2 * np.pi * 117.0 * harmonic * time) / harmonic for harmonic in (1, 2, 3, 5))
    water = shaped(length, noise, lambda hertz: (hertz > 900) & (hertz < 5000))
    tap = np.interp(time / time[-1], (0.3, 0.34, 0.62, 0.66), (0.0, 1.0, 1.0, 0.0))
    # A fan is never quite even.
    unevenness = 1 + 0.2 * np.sin(2 * np.pi * 0.7 * time)
    return hum + 0.5 * fan * unevenness + 0.8 * water * tap + clinks(length, noise)


def clinks(length: int, noise: np.random.Generator) -> Sound:
    """Dishes that touch now and then: a few high partials that die away."""
    sound = np.zeros(length)
    time = np.arange(SAMPLE_RATE // 4) / SAMPLE_RATE
    for start in np.arange(0.4, length / SAMPLE_RATE - 1, 2.3) + noise.uniform(0, 0.7):
        partials = noise.uniform(2500, 7000, size=5)
        decays = noise.uniform(20, 60, size=5)
        ring = sum(
            np.exp(-decay * time) * np.sin(2 * np.pi * hertz * time)
            for hertz, decay in zip(partials, decays, strict=True)
        )
        first = int(start * SAMPLE_RATE)
        sound[first : first + len(time)] += noise.uniform(0.5, 2.0) * ring
    return sound


def speak_all(planned: list[Fixture], description: str) -> list[Sound]:
    """Make the samples of all recordings; the engines are other processes, one on each core."""
    with ThreadPoolExecutor(os.cpu_count()) as pool:
        return list(with_bar(pool.map(Fixture.samples, planned), description, len(planned)))


def main(
    output: Annotated[
        Path,
        typer.Option(
            help="Folder to fill; what an earlier run made there is replaced.",
            show_default="audio_fixtures",
        ),
    ] = FIXTURES,
    commands: Annotated[
        Path, typer.Option(help="Command list, one a line.", show_default="lm/comandos_voz.txt")
    ] = COMMANDS,
    lists: Annotated[
        Path | None,
        typer.Option(
            help="Speak the lists of audio_fixtures/lists/ instead, into a folder each in here."
        ),
    ] = None,
) -> None:
    """Make the recordings of audio_fixtures/ anew, with Debian's synthetic voices.

    Example: python tools/make_fixtures.py --output /tmp/fixtures
    """
    console = Console(stderr=True)
    try:
        if lists and (output, commands) != (FIXTURES, COMMANDS):
            raise ConfigError("--lists goes without --output and --commands; name the folder by it")
        if lists:
            planned = {lists / name: list(list_clips(name)) for name in list_names()}
        else:
            planned = {output: list(fixtures(lines(commands)))}
        for folder, recordings in planned.items():
            # Nothing is replaced before everything is made.
            made = speak_all(recordings, f"Speaking {folder.name}")
            write(folder, list(zip(recordings, made, strict=True)))
            console.print(f"{len(made)} recordings in {folder}", highlight=False, soft_wrap=True)
    except (OSError, VozError) as error:
        console.print(str(error), style="red", markup=False, highlight=False, soft_wrap=True)
        raise typer.Exit(2) from error


if __name__ == "__main__":
    typer.run(main)
