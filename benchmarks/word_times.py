"""How well the times of words are known, by the network and by pocketsphinx alone.

Run `python benchmarks/word_times.py [MANIFEST]`: festival says each command of voz by three voices,
and when each word of it begins and ends. With a manifest, also how far the two are apart for the
words of its commands, of which nobody knows the times. Positive is later.
"""

from __future__ import annotations

import random
import subprocess
from collections.abc import Iterable, Iterator
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Annotated

import numpy as np
import soundfile
import typer
from machine import machine, one_line_errors
from rich.console import Console
from rich.table import Table

import voz
from voz.api.recognizer import Recognizer
from voz.apps.recordings.manifest import read_manifest
from voz.events import SpokenWord

VOICES = ("kal_diphone", "ked_diphone", "cmu_us_slt_arctic_hts")

SPEAK = """
(voice_{voice})
(set! said (utt.synth (Utterance Text "{text}")))
(utt.save.wave said "{wav}" 'riff)
(mapcar
  (lambda (word) (format t "%f %f\\n" (item.feat word "word_start") (item.feat word "word_end")))
  (utt.relation.items said 'Word))
"""

PAUSE = 0.7
"""Seconds of a quiet room before and after a command."""

ROOM = 10.0
"""Standard deviation of its noise, in units of 16 bits."""

Times = list[tuple[float, float]]


def spoken(voice: str, text: str, wav: Path) -> tuple[np.ndarray, int, Times]:
    """Let festival say a command in a quiet room; returns the sound, its rate, and the times."""
    program = SPEAK.format(voice=voice, text=text, wav=wav)
    done = subprocess.run(
        ["festival", "--pipe"], input=program, capture_output=True, text=True, check=True
    )
    said, rate = soundfile.read(wav, dtype="int16")
    noise = np.random.default_rng(0).normal(0, ROOM, len(said) + 2 * int(PAUSE * rate))
    noise[int(PAUSE * rate) :][: len(said)] += said / 2
    times = [tuple(map(float, line.split())) for line in done.stdout.splitlines() if line]
    return noise.astype(np.int16), rate, [(begin + PAUSE, end + PAUSE) for begin, end in times]


def words_of(recognizer: Recognizer, sound: object, rate: float | None, text: str) -> Times:
    """When the words of a command were said; nothing if it was not heard."""
    heard = recognizer.decode(sound, rate, words=True)  # type: ignore[arg-type]
    return next(([times(word) for word in each.words] for each in heard if each.text == text), [])


def times(word: SpokenWord) -> tuple[float, float]:
    return word.start, word.end


def row(name: str, pairs: Iterable[tuple[Times, Times]]) -> Iterator[tuple[str, ...]]:
    """Rows of a table: how much later the first of each pair is than the second."""
    errors = [
        [1000 * (one - other) for one, other in zip(word, known, strict=True)]
        for these, those in pairs
        for word, known in zip(these, those, strict=False)
    ]
    for where, column in zip(("begin", "end"), np.array(errors).T, strict=True):
        figures = (np.median(column), *np.percentile(column, [10, 90]), np.abs(column).mean())
        yield name, where, str(len(column)), *(f"{figure:.0f}" for figure in figures)


def main(
    manifest: Annotated[Path | None, typer.Argument(help="Commands by people.")] = None,
    most: Annotated[int, typer.Option(help="How many of them.")] = 150,
) -> None:
    """Print the table."""
    network, alone = voz.load(), voz.load(settings=voz.Recognition(use_network=False))
    table = Table("", "words", "number", "median, ms", "10 %", "90 %", "mean of sizes")
    said: dict[str, list[tuple[Times, Times]]] = {"network": [], "pocketsphinx": []}
    with TemporaryDirectory() as folder:
        for voice in VOICES:
            for text in network.commands:
                sound, rate, known = spoken(voice, text, Path(folder, "said.wav"))
                for name, recognizer in (("network", network), ("pocketsphinx", alone)):
                    said[name].append((words_of(recognizer, sound, rate, text), known))
    for name, pairs in said.items():
        for cells in row(f"{name}, festival", pairs):
            table.add_row(*cells)
    if manifest:
        clips = [clip for clip in read_manifest(manifest) if clip.kind == "command"]
        random.Random(0).shuffle(clips)
        both = [
            (words_of(network, c.path, None, c.text), words_of(alone, c.path, None, c.text))
            for c in clips[:most]
        ]
        for cells in row("network, later than pocketsphinx", both):
            table.add_row(*cells)
    console = Console(width=110)
    console.print(machine())
    console.print(table)


if __name__ == "__main__":
    with one_line_errors():
        typer.run(main)
