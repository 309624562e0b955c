"""What the second ear alone would decide by one score, in streams of a room that is never quiet.

Run `python benchmarks/one_score.py FOLDER --network training/taught.npz`. FOLDER has a `said.json`:
for each stream `NAME.wav` beside it (16 kHz) a list of [start, end, text or null for a near-miss],
in seconds; of `talk` nothing is a command. The score of a command, in nats, is the largest over
where it begins and ends in a stretch of speech: its log-likelihood less that of the best symbols in
the same moments, 2 for each of its phones, less 2.5 for each phone that is left before or behind
it, and half of the margin to the next command, 6 at most. One threshold holds for all commands: the
lowest at which `talk` raises no more than so many alarms.
"""

from __future__ import annotations

import json
from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import Annotated, Any, NamedTuple

import numpy as np
import numpy.typing as npt
import soundfile
import typer
from rich.console import Console
from rich.progress import track

from voz.audio import SAMPLE_RATE, Samples
from voz.audio.endpointing.segmenter import segments
from voz.language.files import find_language
from voz.recognition.accents import spellings
from voz.recognition.ctc import TINY, Floats, Lattice, lattice
from voz.recognition.language import load_language
from voz.recognition.phoneme_network import BLANKS
from voz.recognition.second_ear import LEAST, load_network, read_sounds

PHONE, OTHER_PHONE = 2.0, 2.5
"""Nats for a phone of the command, and for one beside it."""

MOST_MARGIN = 6.0

AROUND = 0.2
"""Seconds that are added to what the end-pointer gives, which has 0.1 on both sides already."""

SHORTEST, LONGEST = 0.3, 6.0
"""Seconds of speech that may hold a command."""

MOST_ENTERED = 600.0
"""The exponential of more overflows."""


class Heard(NamedTuple):
    """The best command of a stretch, and its score."""

    start: float
    end: float
    text: str
    score: float


class Scorer:
    """Scores the commands of a list by one network; each word is said as the dictionary has it."""

    def __init__(self, network: str | None) -> None:
        """Load the network and the list that comes with voz."""
        self._network = load_network(network)
        language = load_language(find_language(None))
        self.commands = list(language.commands.listed)
        sounds = read_sounds()
        numbers = {phone: number for number, phone in enumerate(sounds)}
        ways = {
            word: [[numbers[phone] for phone in way] for way in said]
            for word, said in spellings(language.pronunciations).items()
        }
        sentences = [[ways[word] for word in text.split()] for text in self.commands]
        self._lattice = lattice(sentences, len(sounds))
        self._phones = np.array([sum(len(word[0]) for word in words) for words in sentences])
        symbols = self._network.symbols
        self._merged = np.zeros((len(symbols), len(sounds) + 1))
        for number, alike in enumerate(sounds.values()):
            self._merged[[symbols.index(symbol) for symbol in alike], number] = 1
        self._merged[-BLANKS:, -1] = 1

    def score(self, samples: Samples) -> tuple[str, float]:
        """Give the best command in some samples, 16 kHz, and its score."""
        heard = np.exp(self._network.log_probabilities(samples)).astype(np.float64)
        blank = heard[:, -BLANKS:].sum(axis=1)
        surest = heard[:, :-BLANKS].argmax(axis=1)
        best = heard[:, :-BLANKS].max(axis=1)
        surest[blank >= best] = -1
        begins = (surest >= 0) & (surest != np.concatenate([[-1], surest[:-1]]))
        probabilities = np.maximum(heard @ self._merged, LEAST)
        found = within(probabilities, np.maximum(best, blank), begins, self._lattice)
        first = int(np.argmax(found + PHONE * self._phones))
        margin = found[first] - np.delete(found, first).max()
        whole = found[first] + PHONE * self._phones[first] + min(MOST_MARGIN, margin / 2)
        return self.commands[first], float(whole)


def within(
    probabilities: Floats, best: Floats, begins: npt.NDArray[np.bool_], sentences: Lattice
) -> Floats:
    """Tell how likely each sentence is, wherever it begins and ends, against the best symbols.

    Args:
        probabilities: moments x symbols.
        best: the probability of the likeliest symbol of each moment.
        begins: whether that begins a phone.
        sentences: as `lattice` lays them.

    Returns:
        A natural logarithm for each, about 0 if it explains all that is heard.
    """
    runs = np.cumsum(begins)
    before = OTHER_PHONE * np.concatenate([[0], runs[:-1]])
    behind = OTHER_PHONE * (runs[-1] - runs)
    symbols = sentences.symbols
    spoken = symbols != symbols[0]  # the first node is a blank
    starts, ends = sentences.starts * spoken, sentences.ends * spoken
    forward, total = np.zeros(len(symbols)), np.zeros(len(sentences.firsts))
    found = np.full(len(sentences.firsts), -np.inf)
    relative = probabilities / best[:, np.newaxis]
    for moment, entered, left in zip(relative, before, behind, strict=True):
        forward = np.add.reduceat(forward[sentences.sources], sentences.reached)
        entry = np.exp(np.minimum(-entered - total, MOST_ENTERED))
        forward = (forward + starts * np.repeat(entry, sentences.sizes)) * moment[symbols]
        scale = np.add.reduceat(forward, sentences.firsts) + TINY
        total += np.log(scale)
        forward /= np.repeat(scale, sentences.sizes)
        ended = np.add.reduceat(forward * ends, sentences.firsts)
        found = np.maximum(found, total + np.log(np.maximum(ended, TINY)) - left)
    return found


def heard_in(path: Path, scorer: Scorer) -> Iterator[Heard]:
    """Score each stretch of speech of a recording."""
    samples, _ = soundfile.read(path, dtype="int16")
    blocks = (samples[at : at + SAMPLE_RATE] for at in range(0, len(samples), SAMPLE_RATE))
    for segment in segments(blocks):
        if SHORTEST < segment.end - segment.start < LONGEST:
            begin, end = segment.start - AROUND, segment.end + AROUND
            stretch = samples[max(0, int(begin * SAMPLE_RATE)) : int(end * SAMPLE_RATE)]
            yield Heard(segment.start, segment.end, *scorer.score(stretch))


def counted(heard: Sequence[Heard], said: Sequence[Sequence[Any]], least: float) -> str:
    """Count what is accepted: commands, near-misses, and what nobody said."""
    left = [each for each in heard if each.score >= least]
    right, near = [], []
    for start, end, text, *_ in said:
        mine = [each for each in left if each.end > start and each.start < end]
        left = [each for each in left if each not in mine]
        if text is None:
            near.append(bool(mine))
        else:
            right.append([each.text for each in mine] == [text])
    return (
        f"{np.mean(right):.3f} right and accepted, near-misses {sum(near)} of {len(near)}, "
        f"out of nothing {len(left)}"
    )


def main(
    folder: Annotated[Path, typer.Argument(help="With said.json and the streams.")],
    network: Annotated[str | None, typer.Option(help="A file of weights; else voz's own.")] = None,
    alarms: Annotated[int, typer.Option(min=0, help="In `talk`, at most.")] = 3,
) -> None:
    """Print what would be obeyed in each stream."""
    scorer = Scorer(network)
    said = json.loads((folder / "said.json").read_text())
    console = Console(stderr=True)
    heard = {
        name: list(heard_in(folder / f"{name}.wav", scorer))
        for name in track(said, console=console, transient=True)
    }
    scores = sorted((each.score for each in heard["talk"]), reverse=True)
    least = np.nextafter(scores[alarms], np.inf)
    print(f"threshold {least:.2f} nats: {alarms} alarms in talk")
    for name, marks in said.items():
        if name != "talk":
            print(f"{name}: {counted(heard[name], marks, least)}")


if __name__ == "__main__":
    typer.run(main)
