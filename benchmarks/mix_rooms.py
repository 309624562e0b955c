"""Mix streams for `rooms.py`: commands and near-misses, one every 4 s, in sound that goes on.

Run `python benchmarks/mix_rooms.py OUT MANIFEST... --held-back`. The manifests list commands,
near-misses, talk and noise. With `--held-back` only those speakers say commands and near-misses
from whom `training/teach.py` learns nothing. Talk is what people in the room say, whoever they are.
With `--words` single words are the commands, listed in OUT/list.txt, and all else is a near-miss.
The speech is louder than the other sound by the decibels in a stream's name: its mean power where
somebody speaks, against the mean power of the whole of the other.
"""

from __future__ import annotations

import json
from collections.abc import Sequence
from pathlib import Path
from typing import Annotated
from zlib import crc32

import numpy as np
import numpy.typing as npt
import soundfile
import typer
from machine import one_line_errors
from msgspec.structs import replace

from voz.apps.recordings.manifest import Clip, read_manifest
from voz.audio import SAMPLE_RATE
from voz.cli.text_io import with_bar
from voz.errors import ConfigError

Sound = npt.NDArray[np.float32]
Random = np.random.Generator

LEVEL = 0.05
"""Mean square root of speech where somebody speaks; full scale is 1."""

HELD_BACK = 16
"""Of so many speakers `training/speech.py` holds one back, by a checksum of the name."""

EVERY = 4 * SAMPLE_RATE
"""Samples from the beginning of one clip to that of the next."""

FLOOR = 1e-4
"""Mean square root of a quiet room; full scale is 1."""

WORDS = "stop go up down left right yes no on off zero one five eight"
"""Single words that people have recorded."""

SHORTEST_TALK = 2 * SAMPLE_RATE
"""Samples: a shorter clip of talk may be a command."""

NOISES = {"kitchen": "doing_the_dishes", "motors": "motor-0", "music": "music-02"}
"""What the files of recorded noise are called."""

ROOMS = (
    ("quiet", None),
    ("kitchen", 15),
    ("kitchen", 10),
    ("babble", 20),
    ("babble", 15),
    ("babble", 10),
    ("talker", 15),
    ("motors", 10),
    ("music", 15),
)
"""The sound that goes on, and by how many decibels the speech is louder."""


def background(name: str, length: int, clips: Sequence[Clip], rng: Random) -> Sound:
    """The sound that goes on in a room, of a mean power of 1."""
    if name in NOISES:
        noises = [read(c) for c in clips if c.kind == "noise" and NOISES[name] in c.file]
        if not noises:
            raise ConfigError(f"no manifest lists a noise that is called {NOISES[name]}")
        sound = np.resize(np.concatenate(noises), length)
    else:
        people = 6 if name == "babble" else 1
        sound = np.sum([somebody(length, clips, rng) for _ in range(people)], axis=0)
    loudness = float(np.sqrt(np.mean(sound.astype(np.float64) ** 2)))
    return np.asarray(sound / loudness, np.float32)


def somebody(length: int, clips: Sequence[Clip], rng: Random) -> Sound:
    """Speech without a pause."""
    talk = [clip for clip in clips if clip.kind == "talk"]
    said: list[Sound] = []
    while sum(map(len, said)) < length:
        one = read(talk[rng.integers(len(talk))])
        if len(one) > SHORTEST_TALK:
            said.append(at_level(one))
    return np.concatenate(said)[:length]


def at_level(sound: Sound) -> Sound:
    """Bring a clip to `LEVEL`, by the power of the 20 ms that are within 30 dB of the loudest."""
    frames = sound[: len(sound) // 320 * 320].reshape(-1, 320).astype(np.float64)
    power = (frames**2).mean(axis=1)
    active = power[power >= power.max() * 1e-3].mean()
    return np.asarray(sound * (LEVEL / (np.sqrt(active) + 1e-9)), np.float32)


def read(clip: Clip) -> Sound:
    """Samples of a recording, from -1 to 1."""
    samples, rate = soundfile.read(clip.path, dtype="float32", always_2d=True)
    if rate != SAMPLE_RATE:
        raise ConfigError(f"{clip.path}: has {rate} Hz; convert it to {SAMPLE_RATE} Hz")
    return np.ascontiguousarray(samples[:, 0])


def mixed(
    clips: Sequence[Clip], sound: Sound | None, ratio: int | None, rng: Random
) -> tuple[Sound, list[tuple[float, float, str | None, str]]]:
    """One stream, and what is said in it, as `rooms.py` reads it."""
    length = EVERY * (len(clips) + 1)
    stream = (FLOOR * rng.standard_normal(length)).astype(np.float32)
    said = []
    for number, clip in enumerate(clips):
        one = at_level(read(clip))
        at = EVERY * (number + 1) - SAMPLE_RATE + int(rng.integers(SAMPLE_RATE // 2))
        one = one[: length - at]
        stream[at : at + len(one)] += one
        text = clip.text if clip.kind == "command" else None
        said.append((at / SAMPLE_RATE, (at + len(one)) / SAMPLE_RATE, text, clip.condition))
    if sound is not None and ratio is not None:
        stream += sound[:length] * (LEVEL / 10 ** (ratio / 20))
    return stream * min(1, 0.95 / np.abs(stream).max()), said


def as_words(clips: Sequence[Clip]) -> list[Clip]:
    """The clips with `WORDS` as commands; others with such a word in them are left out."""
    said = [clip for clip in clips if clip.kind in ("command", "near-miss") and clip.text]
    listed = set(WORDS.split())
    words = [replace(clip, kind="command") for clip in said if clip.text in listed]
    others = [clip for clip in said if not listed & {*clip.text.split()}]
    noises = [clip for clip in clips if clip.kind in ("talk", "noise")]
    return [*words, *(replace(clip, kind="near-miss") for clip in others), *noises]


def is_held_back(speaker: str) -> bool:
    """Whether the network learns nothing from a speaker."""
    return crc32(speaker.encode()) % HELD_BACK == 0


def is_scored(speaker: str) -> bool:
    """Whether a speaker is of the half by whom nothing but the network was chosen."""
    return crc32(speaker.encode()) % 2 == 0


def main(
    out: Annotated[Path, typer.Argument(help="Folder of the streams and their list.")],
    manifests: Annotated[list[Path], typer.Argument(help="Lists of recordings.")],
    seed: Annotated[int, typer.Option(help="Of the order and all that is random.")] = 1,
    held_back: Annotated[bool, typer.Option(help="Only speakers never learned from.")] = False,
    words: Annotated[bool, typer.Option(help="Single words are the commands.")] = False,
    most: Annotated[int, typer.Option(min=1, help="Commands at most, and near-misses.")] = 150,
) -> None:
    """Mix streams of commands in rooms.

    Example: python benchmarks/mix_rooms.py rooms dev/manifest.tsv people/manifest.tsv --held-back
    """
    clips = [clip for path in manifests for clip in read_manifest(path)]
    out.mkdir(parents=True, exist_ok=True)
    if words:
        clips = as_words(clips)
        (out / "list.txt").write_text(WORDS.replace(" ", "\n"))
    rng = np.random.default_rng(seed)
    said: list[Clip] = []
    for kind in ("command", "near-miss"):
        of_kind = [c for c in clips if c.kind == kind and c.condition != "robotic"]
        of_kind = [c for c in of_kind if not held_back or is_held_back(c.speaker)]
        order = rng.permutation(len(of_kind))[:most]
        said += [of_kind[place] for place in order]
    if not said:
        raise ConfigError("nobody says anything; give manifests of commands and near-misses")
    said = [said[place] for place in rng.permutation(len(said))]
    listing = {}
    for name, ratio in with_bar(ROOMS, "mixing"):
        sound = None if ratio is None else background(name, EVERY * (len(said) + 1), clips, rng)
        title = name if ratio is None else f"{name}-{ratio}"
        stream, listing[title] = mixed(said, sound, ratio, np.random.default_rng(seed))
        soundfile.write(out / f"{title}.wav", stream, SAMPLE_RATE, subtype="PCM_16")
    (out / "said.json").write_text(json.dumps(listing))
    speakers = len({clip.speaker for clip in said})
    commands = sum(clip.kind == "command" for clip in said)
    print(f"{len(ROOMS)} streams: {commands} commands and {len(said) - commands} near-misses, by")
    print(f"{speakers} speakers")


if __name__ == "__main__":
    with one_line_errors():
        typer.run(main)
