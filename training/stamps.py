"""What people who speak other languages call things, to learn from: the stamps of Tux Paint.

    python training/stamps.py OUT STAMPS

STAMPS is the folder `usr/share/tuxpaint/stamps` of Debian's `tuxpaint-stamps-default` (GPL-2 or
later, https://tuxpaint.org). Each picture has a text in many languages, and in some a person reads
it. What the network reads quite otherwise has another text, and is left out.
"""

from __future__ import annotations

import csv
import re
from collections.abc import Iterator
from pathlib import Path
from statistics import median
from typing import Annotated, NamedTuple

import numpy as np
import soundfile
import torch
import typer
from foreign_words import Text, spoken, write
from loss import Phones
from mixing import at_level
from network import Network
from noises import Sound
from speech import LONGEST, sounds_of

from voz.audio import SAMPLE_RATE
from voz.cli.text_io import with_bar
from voz.language.espeak import accents_of, written_by_espeak
from voz.language.phones import known_phones
from voz.recognition.network.phoneme_network import OTHER_LANGUAGES, read_network
from voz.recognition.network.symbols import with_symbols

LANGUAGES = ("be", "bg", "ca", "el", "es", "fr", "ro", "ru")
"""Those that a person reads hundreds of."""

RECORDING = re.compile(rf"(?P<picture>.+)_desc_(?P<language>{'|'.join(LANGUAGES)})\.ogg")

MOST_LOSS = 1.6
"""So many times the loss that half of a language's recordings have, another text is likelier."""

LOUD = 1e-3
"""Of the largest power: what is quieter before and after the speech is cut off."""

EDGE, FRAME = SAMPLE_RATE * 3 // 20, SAMPLE_RATE // 100
"""Samples that stay around the speech, and that are as loud as their mean."""

PADDING = SAMPLE_RATE * 3 // 10
"""Samples of silence around what the network reads."""


class Reading(NamedTuple):
    """A recording, with the phones that fit it best, and their loss, nats a phone."""

    path: str
    text: Text
    phones: str
    seconds: float
    loss: float


def main(
    out: Annotated[Path, typer.Argument(help="Folder of the recordings and their manifest.tsv.")],
    stamps: Annotated[Path, typer.Argument(help="Folder of the stamps.")],
) -> None:
    """Bring recordings of people into the form that teach.py reads.

    Example: python training/stamps.py people stamps
    """
    (out / "clips").mkdir(parents=True, exist_ok=True)
    recordings = sorted(recordings_in(stamps))
    if not recordings:
        typer.echo(f"stamps.py: {stamps} has no recordings such as owl_desc_es.ogg", err=True)
        raise typer.Exit(2)
    phones = pronounced([text for _, text in recordings])
    network = Judge()
    read = []
    for number, (path, text) in enumerate(with_bar(recordings, "Reading")):
        name = f"clips/{number:05}.flac"
        seconds = write(out / name, *cut(path))
        if seconds and seconds <= LONGEST and phones[text]:
            loss, best = min((network.loss(out / name, way), way) for way in phones[text])
            read.append(Reading(name, text, best, seconds, loss))
    with (out / "manifest.tsv").open("w", encoding="utf-8", newline="") as file:
        table = csv.writer(file, delimiter="\t", lineterminator="\n")
        table.writerow(("path", *Text._fields, "phones", "speaker", "seconds"))
        for one in fitting(read):
            speaker = f"stamps-{one.text.language}"
            table.writerow((one.path, *one.text, one.phones, speaker, f"{one.seconds:.2f}"))


def recordings_in(stamps: Path) -> Iterator[tuple[Path, Text]]:
    """The recordings of a folder whose text has words alone, with that text."""
    for path in stamps.rglob("*.ogg"):
        named = RECORDING.fullmatch(path.name)
        if not named:
            continue
        texts = path.with_name(f"{named['picture']}.txt")
        lines = texts.read_text(encoding="utf-8").splitlines() if texts.exists() else []
        start = f"{named['language']}.utf8="
        for line in lines:
            if line.startswith(start) and not re.search("[0-9$]", line[len(start) :]):
                said = " ".join(re.sub(r"[^\w'’ ·-]", " ", line[len(start) :]).split())  # noqa: RUF001
                yield path, Text(named["language"], said, "talk")


def pronounced(texts: list[Text]) -> dict[Text, list[str]]:
    """The phones of each text in each accent, if all of them are known."""
    found: dict[Text, list[str]] = {text: [] for text in texts}
    for language in LANGUAGES:
        own = [text for text in found if text.language == language]
        for accent in accents_of(language):
            written = written_by_espeak([text.text for text in own], accent)
            for text, line in zip(own, written, strict=True):
                phones = spoken(text, accent, line).phones
                if phones and known_phones().issuperset(phones.split()):
                    found[text].append(phones)
    return found


def cut(path: Path) -> tuple[Sound, int]:
    """A recording in one channel without the silence around it, and its rate, Hz."""
    channels, rate = soundfile.read(path, dtype="float32", always_2d=True)
    sound = channels.mean(axis=1)
    edge, frame = (size * rate // SAMPLE_RATE for size in (EDGE, FRAME))
    power = (sound[: len(sound) // frame * frame].reshape(-1, frame) ** 2).mean(axis=1)
    loud = np.flatnonzero(power > LOUD * power.max(initial=0.0))
    if not len(loud):
        return sound[:0], rate
    return sound[max(0, loud[0] * frame - edge) : (loud[-1] + 1) * frame + edge], rate


class Judge:
    """Tells by voz's network how far phones are from a recording."""

    def __init__(self) -> None:
        file = read_network(OTHER_LANGUAGES)
        self._network = Network(file.weights).eval()
        self._phones = Phones(file.description.symbols, sounds_of("es"), torch.device("cpu"))

    @torch.no_grad()
    def loss(self, path: Path, phones: str) -> float:
        """Nats a phone."""
        sound, _ = soundfile.read(path, dtype="float32")
        symbols = self._network(torch.tensor(np.pad(at_level(sound), PADDING))[None])
        label = with_symbols(phones.split())
        likely = self._phones.log_probabilities(symbols)
        return float(self._phones.loss(likely, [label])[0]) / len(label)


def fitting(read: list[Reading]) -> list[Reading]:
    """Those whose phones are near to what the network reads, for their language."""
    found = []
    for language in LANGUAGES:
        own = [one for one in read if one.text.language == language]
        most = MOST_LOSS * median(one.loss for one in own) if own else 0.0
        found += [one for one in own if one.loss <= most]
    return found


if __name__ == "__main__":
    typer.run(main)
