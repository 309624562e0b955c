"""Which words the second ear's network writes unlike the dictionary: it learned them by heart.

Run `python benchmarks/readings.py MANIFEST...`; `voz eval --help` tells what a manifest is, and
`words.py` beside this one makes one of synthetic voices. Of each recording of a single word it
takes the symbols that the network is surest of. Where the dictionary explains half of a word's
recordings badly, and many speakers' are written alike, that is the word's reading. It is found with
the recordings of half of the speakers, and must hold for the other half, whose figures are printed.
`--write` puts the readings into `voz/recognition/readings.tsv`, `--check` exits with 1 if that has
others.
"""

from __future__ import annotations

import sys
from collections import Counter, defaultdict
from collections.abc import Iterable, Iterator, Sequence
from itertools import groupby
from pathlib import Path
from statistics import median
from typing import Annotated, NamedTuple
from zlib import crc32

import soundfile
import typer
from rich.console import Console
from rich.progress import track

from voz.audio import SAMPLE_RATE, Samples
from voz.errors import VozError
from voz.language.lexicon import look_up, read_cmudict
from voz.recognition.accents import Phones, spellings, with_accents
from voz.recognition.phoneme_network import BLANKS
from voz.recognition.second_ear import READINGS, SecondEar, load_network
from voz.recordings.clips import Clip
from voz.recordings.manifest import read_manifest

FAR = -0.7
"""Nats for each phone: the dictionary explains a word badly if half of its recordings fit worse."""

GAIN = 0.7
"""Nats for each phone by which the median must rise with the reading."""

SHARE = 0.35
"""Of the recordings of a word, as many must be written as the reading is, to the letter."""

FEWEST = 4
"""Recordings of a word in each half of the speakers."""

HEADER = """\
# Words that the second ear's network writes unlike the dictionary: it learned them by heart, most
# of them as a Spaniard would read their letters. Found and written by `benchmarks/readings.py`.
# Of the speakers who took no part in finding it: how many recordings, the share that is written so
# to the letter, and the median fit in nats for each phone by the dictionary alone and with it.
# word	reading	recordings	share	dictionary	with reading
"""


class Half(NamedTuple):
    """What the network makes of the recordings of a word by half of the speakers.

    Attributes:
        recordings: how many there are.
        share: of those that are written as the reading is.
        before: the median fit by the dictionary alone, nats for each phone.
        after: the same with the reading.
    """

    recordings: int
    share: float
    before: float
    after: float


class Finding(NamedTuple):
    """A word, what the network writes for it, and how that fits each half of the speakers."""

    word: str
    reading: tuple[str, ...]
    fitted: Half
    others: Half

    @property
    def is_reading(self) -> bool:
        """Whether it holds, for both halves."""
        return all(
            half.share >= SHARE and half.before < FAR and half.after - half.before >= GAIN
            for half in (self.fitted, self.others)
        )

    def line(self) -> str:
        """Write it as the file has it."""
        recordings, share, before, after = self.others
        figures = f"{recordings}\t{share:.2f}\t{before:.2f}\t{after:.2f}"
        return f"{self.word}\t{' '.join(self.reading)}\t{figures}"


class Reader:
    """Writes down what the network hears."""

    def __init__(self) -> None:
        """Load the network and the dictionary."""
        self._network = load_network()
        self._cmudict = read_cmudict()

    def read(self, samples: Samples) -> tuple[str, ...]:
        """Give the likeliest symbols, without the blanks between them."""
        best = self._network.log_probabilities(samples).argmax(axis=1)
        symbols = self._network.symbols
        heard = (number for number, _ in groupby(best) if number < len(symbols) - BLANKS)
        return tuple(symbols[number] for number in heard)

    def phones(self, word: str) -> list[Phones]:
        """Give the pronunciations of a word; none if the dictionary does not have it."""
        found = enumerate(look_up(self._cmudict, word), start=1)
        named = {f"{word}({number})": tuple(phones.split()) for number, phones in found}
        return spellings(with_accents(named)).get(word, [])

    def find(self, word: str, clips: Sequence[Clip]) -> Finding | None:
        """Find what the network writes for a word; None if too few say it."""
        halves: tuple[list[Samples], list[Samples]] = ([], [])
        for clip in clips:
            halves[half_of(clip.speaker)].append(samples_of(clip.path))
        ways = self.phones(word)
        if not ways or min(map(len, halves)) < FEWEST:
            return None
        written = [[self.read(samples) for samples in half] for half in halves]
        counts = Counter(filter(None, written[0]))
        if not counts:
            return None
        reading = counts.most_common(1)[0][0]
        before = SecondEar({word: ways}, {})
        after = SecondEar({word: ways}, {word: reading})
        found = [
            Half(
                len(half),
                texts.count(reading) / len(half),
                median(before.opinion(samples, [word]).fit(word) for samples in half),
                median(after.opinion(samples, [word]).fit(word) for samples in half),
            )
            for half, texts in zip(halves, written, strict=True)
        ]
        return Finding(word, reading, *found)


def half_of(speaker: str) -> int:
    """Put a speaker into one of two halves; `festival_slt` and `rhvoice-slt` are one person."""
    person = speaker.replace("-", "_").split("_")[-1]
    return crc32(person.encode()) % 2


def samples_of(path: Path) -> Samples:
    """Read a recording; raises VozError if it has another rate."""
    samples, rate = soundfile.read(path, dtype="int16", always_2d=True)
    if rate != SAMPLE_RATE:
        raise VozError(f"{path}: has {rate} Hz; bring it to {SAMPLE_RATE} Hz")
    mono: Samples = samples[:, 0]
    return mono


def single_words(manifests: Iterable[Path]) -> dict[str, list[Clip]]:
    """Collect the recordings of single words."""
    found: dict[str, list[Clip]] = defaultdict(list)
    for manifest in manifests:
        for clip in read_manifest(manifest):
            if clip.kind in ("command", "near-miss") and len(clip.text.split()) == 1:
                found[clip.text].append(clip)
    return dict(sorted(found.items()))


def findings(manifests: Iterable[Path]) -> Iterator[Finding]:
    """Find the reading of each word that enough speakers say."""
    reader = Reader()
    words = single_words(manifests)
    for word, clips in track(words.items(), console=Console(stderr=True), transient=True):
        found = reader.find(word, clips)
        if found:
            yield found


def main(
    manifests: Annotated[list[Path], typer.Argument(help="Recordings of single words.")],
    write: Annotated[bool, typer.Option(help="Write the file.")] = False,
    check: Annotated[bool, typer.Option(help="Exit with 1 if the file has others.")] = False,
) -> None:
    """Print the words that fit badly, and their readings."""
    found = sorted(findings(manifests), key=lambda finding: finding.others.before)
    print(f"{len(found)} words; reading, and (fitted, others): recordings, share, before, after")
    for finding in found:
        if finding.is_reading or finding.fitted.before < FAR:
            mark = "*" if finding.is_reading else " "
            halves = ", ".join(
                f"({h.recordings} {h.share:.2f} {h.before:.2f} {h.after:.2f})"
                for h in (finding.fitted, finding.others)
            )
            print(f"{mark} {finding.word}: {' '.join(finding.reading)} {halves}")
    lines = sorted(finding.line() for finding in found if finding.is_reading)
    text = HEADER + "".join(f"{line}\n" for line in lines)
    if write:
        READINGS.write_text(text, encoding="utf-8")
    if check and READINGS.read_text(encoding="utf-8") != text:
        sys.exit(f"{READINGS}: has other readings; write them with --write")


if __name__ == "__main__":
    typer.run(main)
