"""What the verdicts of `voz devices --test` are worth: how many commands are obeyed under each.

Run `python benchmarks/microphone.py MANIFEST...`. The manifests list commands, and noise; `voz eval
--help` tells what a manifest is. Commands that are obeyed as they are get quieter, are cut off, or
have noise behind them.
"""

from __future__ import annotations

import sys
from collections import defaultdict
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import NamedTuple

import numpy as np
import numpy.typing as npt
from machine import machine

from voz.api.recognizer import Recognizer
from voz.apps.evaluation.noise import generator_for, mix, random_stretch
from voz.apps.recordings.manifest import Clip, read_manifests
from voz.audio import SAMPLE_RATE, Samples
from voz.audio.recording_level import Fault, RecordingLevel, find_faults, measure_level
from voz.audio.sound_files import read_blocks
from voz.language.language_files import LanguageFiles
from voz.settings import Recognition

LM = Path(__file__).parent.parent / "lm"
LENGTH = 3 * SAMPLE_RATE
PAUSE = 2 * SAMPLE_RATE // 3  # before the command
HISS = 8.0  # units of the 16 bits: a quiet room, -72 dBFS
LOUD = 10_000  # the highest sample of a command, 10 dB below full scale
MOST = 80  # clips

LOUDER = (0, -10, -20, -30, -40, -50, 12, 18, 24, 30)  # dB
RATIOS = (30, 25, 20, 15, 10, 5, 0)  # dB


class Tried(NamedTuple):
    """A recording, what it is like, and whether its command was obeyed."""

    level: RecordingLevel
    obeyed: bool


def main(manifests: list[Path]) -> None:
    clips = read_manifests(manifests)
    noises = [read(c.path) for c in clips if c.kind == "noise"]
    commands = [c for c in clips if c.kind == "command" and read(c.path).any()]
    recognizer = Recognizer(LanguageFiles(LM), Recognition())
    tried = []
    for clip in commands[:: max(1, len(commands) // MOST)]:
        plain, *others = recordings(clip, noises)
        if obeyed(recognizer, plain, clip.text):
            tried += [Tried(measure_level(o), obeyed(recognizer, o, clip.text)) for o in others]
    print(f"{machine()}\n{len(tried)} recordings of commands that are obeyed as they are\n")
    print_table(
        "verdict", tried, lambda t: ", ".join(f.name for f in find_faults(t.level)) or "fine"
    )
    print_table("speech above background, dB", alone(Fault.NOISY, tried), ratio)
    print_table("speech, dBFS", alone(Fault.TOO_QUIET, tried), loudness)
    print_table("of the speech at the top", alone(Fault.CLIPPED, tried), share_at_top)


def recordings(clip: Clip, noises: list[Samples]) -> Iterator[Samples]:
    """Make three seconds of a command: as it is, louder and quieter, and in noise."""
    rng = generator_for(clip.file)
    samples = read(clip.path)[: LENGTH - PAUSE].astype(np.float64)
    sound = rng.standard_normal(LENGTH) * HISS
    sound[PAUSE : PAUSE + len(samples)] += samples * (LOUD / np.abs(samples).max())
    yield within_16_bits(sound)
    for decibels in LOUDER:
        yield within_16_bits(sound * 10 ** (decibels / 20))
    noise = noises[rng.integers(len(noises))]
    for ratio in RATIOS:
        yield mix(within_16_bits(sound), random_stretch(noise, LENGTH, rng), ratio)


def read(path: Path) -> Samples:
    return np.concatenate([np.empty(0, np.int16), *read_blocks(path)])


def within_16_bits(sound: npt.NDArray[np.float64]) -> Samples:
    return np.clip(np.round(sound), -32768, 32767).astype(np.int16)


def obeyed(recognizer: Recognizer, samples: Samples, text: str) -> bool:
    heard = recognizer.utterances([samples], "")
    return [u.text for u in heard if u.accepted] == [text]


def alone(fault: Fault, tried: list[Tried]) -> list[Tried]:
    """Keep what has no other fault."""
    return [t for t in tried if set(find_faults(t.level)) <= {fault}]


def ratio(tried: Tried) -> float:
    return band(tried.level.above_background, (-99, 5, 10, 14, 18, 22, 28))


def loudness(tried: Tried) -> float:
    return band(tried.level.speech, (-99, -60, -50, -45, -40, -35, -30))


def share_at_top(tried: Tried) -> float:
    return band(tried.level.at_top, (0, 0.003, 0.01, 0.03, 0.1, 0.2))


def band(figure: float | None, edges: tuple[float, ...]) -> float:
    assert figure is not None
    return max(edge for edge in edges if edge <= figure)


def print_table(
    title: str, tried: list[Tried], row_of: Callable[[Tried], str] | Callable[[Tried], float]
) -> None:
    """Print how many are obeyed; a row with a figure is from there up to the next one's."""
    rows = defaultdict(list)
    for one in tried:
        rows[row_of(one)].append(one.obeyed)
    print(f"| {title} | recordings | obeyed |\n|---|---|---|")
    for name, results in sorted(rows.items()):
        print(f"| {name} | {len(results)} | {np.mean(results):.2f} |")
    print(flush=True)


if __name__ == "__main__":
    main([Path(name) for name in sys.argv[1:]])
