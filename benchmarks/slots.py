"""Whether the slots of an order that is obeyed are those that were said, and how sure it is then.

Run `python benchmarks/slots.py MANIFEST... [--seed N]`; the manifests list noise and talk.
Synthetic voices say orders, drawn by the seed from lists with slots, in quiet and in the sound of a
kitchen, of motors, of six people and of music, so many decibels below the speech. Prints for each
ratio how many orders are obeyed right, obeyed wrong (another order, or another value of a slot) and
asked about (`ask = "always"`; in brackets with the right one), and for each confidence what share
of the obeyed orders is right.
"""

from __future__ import annotations

import os
import subprocess
from collections.abc import Iterator, Sequence
from concurrent.futures import ProcessPoolExecutor
from functools import cache, partial
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Annotated, NamedTuple

import numpy as np
import soundfile
import soxr
import typer
from machine import machine, one_line_errors
from mix_rooms import FLOOR, LEVEL, Sound, at_level, background

from voz.api.recognizer import Recognizer
from voz.apps.recordings.manifest import Clip, read_manifest
from voz.audio import SAMPLE_RATE
from voz.audio.sound_files import to_int16
from voz.language.build import build
from voz.language.language_files import LanguageFiles
from voz.language.sentences.command_set import Parse
from voz.settings import Recognition

ARM = Path(__file__).parent.parent / "examples" / "arm" / "commands.txt"

LISTS = {
    "servo": "set servo {number: 1..8} to {angle: 0..180 by 5}\ncenter servo {number: 1..8}\nstop",
    "few": "set servo {number: 1..4} to {angle: 0..90 by 10}\ncenter servo {number: 1..4}\n"
    "light {color}\ncolor = red | green | blue | white\nstop",
    "turn": "turn {side} {angle: 5..180 by 5} degrees\ndrive {far: 0.5..5 by 0.5} meters\n"
    "look {side}\nside = left | right\nstop",
    "arm": ARM.read_text(encoding="utf-8"),
}

VOICES = {
    "ked": ("text2wave", "-eval", "(voice_ked_diphone)", "-o"),
    "rms": ("flite", "-voice", "rms", "-o"),
    "awb": ("flite", "-voice", "awb", "-o"),
    "scotland": ("espeak-ng", "--stdin", "-v", "en-gb-scotland", "-w"),
    "us-f4": ("espeak-ng", "--stdin", "-v", "en-us+f4", "-w"),
}
"""Programs that read text and write the file named last; nothing was chosen by these voices."""

NOISES = ("kitchen", "motors", "babble", "music")
RATIOS = (None, 10, 5, 0, -3, -6)
"""Of speech to noise, dB."""

BEFORE, AFTER = 2 * SAMPLE_RATE, SAMPLE_RATE
NOISE_SECONDS = 60
CONFIDENCES = (0.0, 0.8, 0.85, 0.9, 0.95, 0.99, 0.995)


class Order(NamedTuple):
    """An order, who says it, and the noise that it is said in."""

    number: int
    listed: str
    text: str
    voice: str
    noise: str
    ratio: int | None


class Result(NamedTuple):
    """What became of an order, and each utterance that was obeyed: how surely, and if right."""

    right: bool
    wrong: bool
    asked: bool
    asked_right: bool
    obeyed: list[tuple[float, bool]]


def orders(seed: int, each: int) -> Iterator[Order]:
    """Draw so many orders for each voice and list."""
    number = 0
    for place, (listed, voice) in enumerate((n, v) for n in LISTS for v in VOICES):
        commands = recognizer(listed).commands
        drawn = commands.sample(10 * each, seed * 1000 + place)
        for text in [text for text in drawn if _parse(listed, text).slots][:each]:
            for ratio in RATIOS:
                for noise in NOISES if ratio is not None else ("",):
                    yield Order(number, listed, text, voice, noise, ratio)
                    number += 1


@cache
def recognizer(listed: str) -> Recognizer:
    """Understands a list."""
    with TemporaryDirectory() as folder:
        path = Path(folder) / "list.txt"
        path.write_text(LISTS[listed], encoding="utf-8")
        build(path, Path(folder) / "lm")
        return Recognizer(LanguageFiles(Path(folder) / "lm"), Recognition(ask="always"))


def _parse(listed: str, text: str) -> Parse:
    found = recognizer(listed).commands.parse(text)
    assert found, text
    return found


@cache
def speech(voice: str, text: str) -> Sound:
    """A text by a voice, 16 kHz."""
    with TemporaryDirectory() as folder:
        file = f"{folder}/said.wav"
        subprocess.run(
            [*VOICES[voice], file], input=text, text=True, check=True, capture_output=True
        )
        sound, rate = soundfile.read(file, dtype="float32")
    return at_level(np.asarray(soxr.resample(sound, rate, SAMPLE_RATE), np.float32))


@cache
def noise_of(name: str, clips: tuple[Clip, ...], seed: int) -> Sound:
    """A minute of a noise."""
    length = NOISE_SECONDS * SAMPLE_RATE
    return background(name, length, clips, np.random.default_rng([seed, NOISES.index(name)]))


def judge(order: Order, clips: tuple[Clip, ...], seed: int) -> Result:
    """Hear an order."""
    whole = np.pad(speech(order.voice, order.text), (BEFORE, AFTER))
    chance = np.random.default_rng([seed, order.number])
    whole += FLOOR * chance.standard_normal(len(whole)).astype(np.float32)
    if order.ratio is not None:
        noise = noise_of(order.noise, clips, seed)
        at = chance.integers(len(noise) - len(whole))
        whole += noise[at : at + len(whole)] * LEVEL / 10 ** (order.ratio / 20)
    sound = to_int16(whole / max(1, 1.05 * np.abs(whole).max()))
    said = _parse(order.listed, order.text)
    meant = said.command, dict(said.slots)
    heard = list(recognizer(order.listed).utterances([sound], ""))
    obeyed = [
        (u.confidence, (u.command or u.text, dict(u.slots)) == meant)
        for u in heard
        if u.accepted and u.text != "stop"
    ]
    asked = [(p.command, dict(p.slots)) for u in heard for p in u.perhaps if not obeyed]
    right = [each for _, each in obeyed]
    return Result(any(right), not all(right), bool(asked), meant in asked, obeyed)


def main(
    manifests: Annotated[list[Path], typer.Argument(metavar="MANIFEST...", help="Of noise, talk.")],
    seed: Annotated[int, typer.Option(help="Of the orders and the noise.")] = 77,
    each: Annotated[int, typer.Option(help="Orders of each list by each voice.")] = 3,
    jobs: Annotated[int, typer.Option(help="Processes.")] = os.cpu_count() or 1,
) -> None:
    """Print what became of the orders, and how true their confidence is."""
    clips = tuple(clip for path in manifests for clip in read_manifest(path))
    every = list(orders(seed, each))
    with ProcessPoolExecutor(jobs) as pool:
        how = partial(judge, clips=clips, seed=seed)
        results = list(pool.map(how, every, chunksize=8))
    print(f"{machine()}; seed {seed}\n")
    print("| dB | orders | obeyed right | obeyed wrong | at .995 or more | asked (right) |")
    print("|---|---|---|---|---|---|")
    for ratio in RATIOS:
        found = [r for o, r in zip(every, results, strict=True) if o.ratio == ratio]
        print(_row("quiet" if ratio is None else str(ratio), found))
    print("\n| confidence | obeyed | of these right |\n|---|---|---|")
    obeyed = [each for result in results for each in result.obeyed]
    for low, high in zip(CONFIDENCES, [*CONFIDENCES[1:], 1.1], strict=True):
        right = [each for sure, each in obeyed if low <= sure < high]
        if right:
            print(f"| {low:g} to {min(high, 1):g} | {len(right)} | {np.mean(right):.3f} |")


def _row(name: str, found: Sequence[Result]) -> str:
    counts = [sum(each) for each in zip(*(result[:4] for result in found), strict=True)]
    right, wrong, asked, asked_right = counts
    surely = sum(any(s >= CONFIDENCES[-1] and not ok for s, ok in r.obeyed) for r in found)
    return f"| {name} | {len(found)} | {right} | {wrong} | {surely} | {asked} ({asked_right}) |"


if __name__ == "__main__":
    with one_line_errors():
        typer.run(main)
