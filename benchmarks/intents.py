"""Spoken orders of coffee, the public benchmark Picovoice/speech-to-intent-benchmark, by voz.

Run `python benchmarks/intents.py DIR` on a copy of that repository: `data/speech/clean/*.wav` (or
`data/speech/*.wav`), `data/label/label.json`, `data/noise/*.wav`. An order is accepted if what is
obeyed first has its intent and all slots of its label; that is how the benchmark counts. Beside it
stands what the benchmark does not count: orders that are obeyed and wrong.

The noise is mixed as the benchmark does it: by the loudest 0.128 s of both, then half of full
scale. It also goes on before and after the clip, as it does for a microphone; `--run-in 0` leaves
that out. `--name "hey robot"` is said before each order, as loud, by one of Debian's voices.
"""

from __future__ import annotations

import json
import os
import sys
import tempfile
import time
from collections.abc import Iterator, Mapping, Sequence
from concurrent.futures import ProcessPoolExecutor
from functools import cache, partial
from itertools import product
from pathlib import Path
from typing import Annotated, Any, NamedTuple

import numpy as np
import soundfile
import typer
from machine import machine

from voz.api.recognizer import Recognizer
from voz.audio import SAMPLE_RATE, Samples
from voz.audio.sound_files import to_int16
from voz.events import Utterance
from voz.language.build import build
from voz.language.language_files import LanguageFiles
from voz.settings import Recognition

sys.path.insert(0, str(Path(__file__).parent.parent / "tools"))

import synthesis  # a script beside the others

NAME_VOICES = ("festival_slt", "flite_rms", "flite_awb")

COFFEE = Path(__file__).parent.parent / "examples" / "coffee.txt"

LEVELS = (24, 18, 12, 6)

PUBLISHED: Mapping[str, Mapping[int, float]] = {
    "Rhino": {24: 0.99, 18: 0.99, 12: 0.98, 6: 0.96},
    "Watson": {24: 0.96, 18: 0.95, 12: 0.89, 6: 0.72},
}
"""Acceptance, the mean of both noises, as the benchmark's page has it."""

FRAME = 2048
"""Samples over which the benchmark looks for the loudest sound."""


class Clip(NamedTuple):
    """An order, its label, and the noise that it is to be heard in; None is as it is."""

    path: Path
    intent: str
    slots: Mapping[str, str]
    noise: Path | None
    level: int


class Result(NamedTuple):
    """What became of a clip."""

    accepted: bool  # as the benchmark counts
    wrong: bool  # another order was obeyed, or one with a slot too many
    right: bool  # it was heard right, obeyed or not
    # Nothing was obeyed, and a robot that asks back would ask whether it was this order.
    asked: bool
    seconds: float  # how much sound there was
    cpu: float  # what it took, s
    heard: str  # what was heard, for people


def clips(folder: Path, noises: Sequence[Path | None], levels: Sequence[int]) -> list[Clip]:
    """All clips in all noises."""
    labels = json.loads((folder / "label" / "label.json").read_text())
    speech = folder / "speech" / "clean"
    found = sorted((speech if speech.is_dir() else speech.parent).glob("*.wav"))
    ways: list[tuple[Path | None, int]] = [
        (noise, level) for noise, level in product(noises, levels) if noise
    ]
    ways = [(None, 0), *ways] if None in noises else ways
    return [
        Clip(path, labels[path.name]["intent"], _stripped(labels[path.name]["slots"]), *way)
        for way in ways
        for path in found
        if path.name in labels
    ]


def _stripped(slots: Mapping[str, Any]) -> dict[str, str]:
    return {name: str(value).strip().lower() for name, value in slots.items()}


def behind(name: str, order: synthesis.Sound, chance: np.random.Generator) -> synthesis.Sound:
    """An order, and the robot's name before it."""
    said = synthesis.speak(NAME_VOICES[chance.integers(len(NAME_VOICES))], name)
    order = synthesis.trimmed(order)
    return np.concatenate([said * (order.std() / said.std()), order])


def mixed(clip: Clip, run_in: float, name: str) -> Samples:
    """A clip in its noise; the same piece of it each time."""
    speech, rate = soundfile.read(clip.path)
    assert rate == SAMPLE_RATE, clip.path
    if name:
        speech = behind(name, speech, np.random.default_rng([*clip.path.name.encode()]))
    around = int(run_in * SAMPLE_RATE)
    whole = np.pad(speech, around)
    if clip.noise:
        noise, _ = soundfile.read(clip.noise)
        chance = np.random.default_rng([clip.level, *clip.path.name.encode()])
        at = chance.integers(0, max(1, len(noise) - len(whole)))
        piece = np.resize(noise[at:], len(whole))
        beside = piece[around : around + len(speech)]
        energies = _loudest(speech) / (_loudest(beside) * 10 ** (clip.level / 10))
        whole = whole + np.sqrt(energies) * piece
        whole = whole / (2 * np.abs(whole).max())
    return to_int16(whole)


def _loudest(sound: synthesis.Sound) -> float:
    frames = sound[: len(sound) // FRAME * FRAME].reshape(-1, FRAME)
    return float((frames**2).sum(axis=1).max())


@cache
def recognizer(lm: str, settings: Recognition) -> Recognizer:
    """One for each process."""
    return Recognizer(LanguageFiles(Path(lm)), settings)


def judge(clip: Clip, lm: str, settings: Recognition, run_in: float) -> Result:
    """Recognize a clip."""
    heard_by, sound = recognizer(lm, settings), mixed(clip, run_in, settings.name)
    began = time.process_time()
    found = heard_by.utterances([sound], clip.path.name)
    heard = [each for each in found if each.text != settings.name]
    cpu = time.process_time() - began
    obeyed = [u for u in heard if u.accepted]
    parses = [heard_by.commands.parse(u.text) for u in heard]
    return Result(
        bool(obeyed) and has_label(obeyed[0], clip),
        any(not is_order(u.command, u.slots, clip) for u in obeyed),
        any(p is not None and is_order(p.command, p.slots, clip) for p in parses),
        not obeyed and any(is_order(p.command, p.slots, clip) for u in heard for p in u.perhaps),
        len(sound) / SAMPLE_RATE,
        cpu,
        " / ".join(f"{u.text} ({u.reason or 'obeyed'} {u.confidence:.2f})" for u in heard),
    )


def has_label(heard: Utterance, clip: Clip) -> bool:
    """Whether the benchmark counts an utterance as right: slots that no label names are free."""
    slots = _stripped(heard.slots)
    named = all(slots.get(name) == value for name, value in clip.slots.items())
    return heard.command == clip.intent and named


def is_order(command: str | None, slots: Mapping[str, Any], clip: Clip) -> bool:
    """Whether it is the order, no more and no less."""
    return command == clip.intent and _stripped(slots) == clip.slots


def table(every: Sequence[Clip], results: Sequence[Result]) -> Iterator[str]:
    """A line for each noise and level."""
    yield (
        "| noise | dB | accepted | Rhino | Watson | obeyed and wrong | heard right | asked right "
        "| real time |"
    )
    yield "|---|---|---|---|---|---|---|---|---|"
    of: dict[tuple[Path | None, int], list[Result]] = {}
    for clip, result in zip(every, results, strict=True):
        of.setdefault((clip.noise, clip.level), []).append(result)
    for (noise, level), found in of.items():
        known = [f"{figures[level]:.2f}" if noise and level in figures else "-"
                 for figures in PUBLISHED.values()]  # fmt: skip
        share = [sum(each) / len(found) for each in zip(*(r[:4] for r in found), strict=True)]
        speed = sum(r.cpu for r in found) / sum(r.seconds for r in found)
        name, decibels = (noise.stem, str(level)) if noise else ("none", "-")
        yield (
            f"| {name} | {decibels} | {share[0]:.3f} | {' | '.join(known)} | {share[1]:.3f} "
            f"| {share[2]:.3f} | {share[3]:.3f} | {speed:.2f} |"
        )


def main(
    folder: Annotated[Path, typer.Argument(metavar="DIR", help="A copy of the benchmark.")],
    listed: Annotated[Path, typer.Option("--list", help="What may be ordered.")] = COFFEE,
    noise: Annotated[list[str] | None, typer.Option(help="Names in data/noise, or none.")] = None,
    level: Annotated[list[int] | None, typer.Option(help="Signal to noise, dB.")] = None,
    run_in: Annotated[float, typer.Option(help="Noise before and after a clip, s.")] = 2.0,
    alarms: Annotated[float | None, typer.Option(help="False alarms an hour.")] = None,
    name: Annotated[str, typer.Option(help="The robot's name, said before each order.")] = "",
    jobs: Annotated[int, typer.Option(help="Processes.")] = os.cpu_count() or 1,
    every: Annotated[bool, typer.Option("--all", help="Show each that was not accepted.")] = False,
) -> None:
    """Print how many orders are accepted, and how many are obeyed that were not given."""
    data = folder / "data" if (folder / "data").is_dir() else folder
    names = noise or ["none", *sorted(path.stem for path in (data / "noise").glob("*.wav"))]
    noises = [None if each == "none" else data / "noise" / f"{each}.wav" for each in names]
    chosen = clips(data, noises, level or LEVELS)
    settings = Recognition(false_alarms_per_hour=alarms, ask="always", name=name)
    with tempfile.TemporaryDirectory(prefix="voz-") as lm:
        built = build(listed, Path(lm))
        print(f"{machine()}; {built.sentences:,} sentences, {len(chosen)} clips")
        with ProcessPoolExecutor(jobs) as pool:
            how = partial(judge, lm=lm, settings=settings, run_in=run_in)
            results = list(pool.map(how, chosen, chunksize=4))
    for line in table(chosen, results):
        print(line)
    for clip, result in zip(chosen, results, strict=True) if every else ():
        if result.wrong or not result.accepted:
            slots = ", ".join(clip.slots.values())
            print(f"{clip.path.name} {clip.level}: {slots} => {result.heard or 'nothing'}")


if __name__ == "__main__":
    typer.run(main)
