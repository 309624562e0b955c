"""Phrases of other languages by synthetic voices, half in pairs one phone apart, to learn from.

    python training/foreign_words.py OUT --engine espeak

espeak-ng tells the phones of what is read. The voices are its own, SVOX Pico's (PyPI's
`py-nanotts`), or Kokoro's, any of which reads any language's phones.
"""

from __future__ import annotations

import csv
import random
import subprocess
import tempfile
from collections import Counter
from collections.abc import Callable, Sequence
from enum import Enum
from itertools import cycle, islice
from pathlib import Path
from typing import Annotated, NamedTuple

import numpy as np
import soundfile
import soxr
import typer
from noises import Sound
from phrases import choose_phrases, one_phone_apart
from wordfreq import top_n_list

from voz.audio import SAMPLE_RATE
from voz.cli.text_io import with_bar
from voz.language.espeak import TIME_LIMIT, accents_of, written_by_espeak
from voz.language.phones import known_phones, parse_phones

SHARES = {"es": 3, "fr": 4, "it": 1, "de": 1, "pt": 1}
"""How often each language is drawn."""

ACCENTS = {language: accents_of(language) for language in SHARES} | {"pt": ("pt", "pt-br")}
"""Of each language, as espeak-ng names them."""

COMMON_WORDS = 8000
"""Words of a language that are read."""

PEAK = 0.5

ESPEAK_VARIANTS = (*(f"m{n}" for n in range(1, 9)), *(f"f{n}" for n in range(1, 6)))

PICO_VOICES = {"es": "es-ES", "fr": "fr-FR", "it": "it-IT", "de": "de-DE"}

KOKORO_SPEEDS = (0.85, 1.4)
"""Of its usual one; people who give orders are faster."""

KOKORO_NATIVES = {"es": "e", "fr": "f", "it": "i", "pt": "p"}
"""The letter that the voices of each language begin with; German has none."""

NATIVE_SHARE = 0.4
"""How often a language is read by a voice of its own."""


class Text(NamedTuple):
    """What is to be read.

    Attributes:
        language: one of `ACCENTS`.
        text: the words.
        kind: `command`, or another.
    """

    language: str
    text: str
    kind: str


class Phrase(NamedTuple):
    """A text, and how it is read.

    Attributes:
        text: what is read.
        accent: of espeak-ng, by whose rules it is read.
        phones: as `voz.language.phones` names them.
        stressed: the same as espeak-ng writes them, with stress.
    """

    text: Text
    accent: str
    phones: str
    stressed: str


Reader = Callable[[Phrase, random.Random], tuple[str, Sound, int]]
"""Reads a phrase; returns the name of the voice, samples, and their rate, Hz."""


class Engine(str, Enum):
    """Programs that speak."""

    ESPEAK = "espeak"
    PICO = "pico"
    KOKORO = "kokoro"


def main(
    out: Annotated[Path, typer.Argument(help="Folder of the recordings and their manifest.tsv.")],
    engine: Annotated[Engine, typer.Option(help="Whose voices read.")] = Engine.ESPEAK,
    kokoro: Annotated[Path, typer.Option(help="Folder of Kokoro's files.")] = Path("kokoro"),
    kept_aside: Annotated[
        bool, typer.Option("--kept-aside", help="By Kokoro's voices that teach nothing: to score.")
    ] = False,
    texts: Annotated[
        Path | None, typer.Option(help="Columns language, text, kind; else common words are read.")
    ] = None,
    clips: Annotated[int, typer.Option(min=1, help="How many recordings.")] = 2000,
    seed: Annotated[int, typer.Option(help="Of the choice of words and voices.")] = 1,
) -> None:
    """Have voices read words and short phrases of Spanish, French, Italian, German, Portuguese.

    Example: python training/foreign_words.py espeak --clips 2000
    """
    (out / "clips").mkdir(parents=True, exist_ok=True)
    rng = random.Random(seed)
    languages = [*(PICO_VOICES if engine is Engine.PICO else ACCENTS)]
    read = reader(engine, kokoro, kept_aside)
    chosen = listed(texts, clips) if texts else common(languages, clips, rng)
    with (out / "manifest.tsv").open("w", encoding="utf-8", newline="") as file:
        table = csv.writer(file, delimiter="\t", lineterminator="\n")
        table.writerow(("path", *Text._fields, "phones", "speaker", "seconds"))
        number = 0
        for group in with_bar(pronounced(chosen, rng), "Reading"):
            same = rng.random()
            for phrase in group:
                voice, sound, rate = read(phrase, random.Random(same))
                path = out / "clips" / f"{number:05}.flac"
                seconds = write(path, sound, rate)
                if seconds:
                    row = (*phrase.text, phrase.phones, voice, f"{seconds:.2f}")
                    table.writerow((path.relative_to(out), *row))
                    number += 1
            file.flush()


def listed(path: Path, count: int) -> list[Sequence[Text]]:
    """So many texts of a file, from the first one on and over again."""
    with path.open(encoding="utf-8", newline="") as file:
        rows = [Text(**row) for row in csv.DictReader(file, delimiter="\t")]
    return [(text,) for text in islice(cycle(rows), count)]


def common(languages: list[str], count: int, rng: random.Random) -> list[Sequence[Text]]:
    """Choose about so many phrases of common words; those of a pair stand together."""
    drawn = rng.choices(languages, [SHARES[language] for language in languages], k=count)
    found: list[Sequence[Text]] = []
    for language, own in Counter(drawn).items():
        words = [word for word in top_n_list(language, COMMON_WORDS) if word.isalpha()]
        written = written_by_espeak(words, ACCENTS[language][0])
        phones = {w: parse_phones(line) for w, line in zip(words, written, strict=True)}
        for group in choose_phrases(one_phone_apart(phones), own, rng):
            found.append([Text(language, " ".join(phrase), "words") for phrase in group])
    return found


def pronounced(groups: list[Sequence[Text]], rng: random.Random) -> list[list[Phrase]]:
    """Have espeak-ng tell the phones of texts, those of a group in one accent.

    What it has an unknown phone for is left out.
    """
    by_accent: dict[str, list[Sequence[Text]]] = {}
    for group in groups:
        by_accent.setdefault(rng.choice(ACCENTS[group[0].language]), []).append(group)
    found = []
    for accent, own in by_accent.items():
        lines = iter(written_by_espeak([each.text for group in own for each in group], accent))
        for group in own:
            phrases = [spoken(text, accent, next(lines)) for text in group]
            found.append([p for p in phrases if known_phones().issuperset(p.phones.split())])
    rng.shuffle(found)
    return found


def spoken(text: Text, accent: str, written: str) -> Phrase:
    """A text with its phones, by what espeak-ng has written."""
    return Phrase(text, accent, " ".join(parse_phones(written)), written.replace("_", ""))


def reader(engine: Engine, kokoro: Path, kept_aside: bool) -> Reader:
    """What reads phrases by the voices of an engine."""
    if engine is Engine.KOKORO:
        return kokoro_reader(kokoro, kept_aside)
    return pico_reader() if engine is Engine.PICO else read_by_espeak


def read_by_espeak(phrase: Phrase, rng: random.Random) -> tuple[str, Sound, int]:
    """Read by a variant of espeak-ng's voice."""
    variant = rng.choice(ESPEAK_VARIANTS)
    speed, pitch = rng.randint(120, 210), rng.randint(25, 75)
    with tempfile.NamedTemporaryFile(suffix=".wav") as file:
        options = ["-v", f"{phrase.accent}+{variant}", "-s", str(speed), "-p", str(pitch)]
        command = ["espeak-ng", *options, "-w", file.name, "--stdin"]
        subprocess.run(
            command, input=phrase.text.text, encoding="utf-8", timeout=TIME_LIMIT, check=True
        )
        sound, rate = soundfile.read(file.name, dtype="float32")
    return f"espeak-{phrase.accent}-{variant}", sound, rate


def pico_reader() -> Reader:
    """Reads by the voice of Pico that a language has."""
    from py_nanotts import NanoTTS  # who reads by another engine needs it not

    nano = NanoTTS()

    def read(phrase: Phrase, rng: random.Random) -> tuple[str, Sound, int]:
        voice = PICO_VOICES[phrase.text.language]
        speed, pitch = rng.uniform(0.8, 1.2), rng.uniform(0.8, 1.2)
        pcm = nano.speak(f"{phrase.text.text}.", voice, speed, pitch)
        return f"pico-{voice}", np.frombuffer(pcm, np.int16).astype(np.float32) / 32768, SAMPLE_RATE

    return read


def kokoro_reader(folder: Path, kept_aside: bool) -> Reader:
    """Reads by Kokoro's voices, by those of the language more often."""
    from kokoro import RATE, Kokoro, choose_voices, speaker_of  # as above

    engine = Kokoro(folder, kept_aside=kept_aside)

    def read(phrase: Phrase, rng: random.Random) -> tuple[str, Sound, int]:
        letter = KOKORO_NATIVES.get(phrase.text.language, "")
        voices = choose_voices(engine.voices, letter, NATIVE_SHARE, rng, mixed=not kept_aside)
        sound = engine.read(f"{phrase.stressed}.", voices, rng.uniform(*KOKORO_SPEEDS))
        return speaker_of(voices), sound, RATE

    return read


def write(path: Path, sound: Sound, rate: int) -> float:
    """Write a recording; returns its length, s, or 0 if it is silent."""
    peak = np.abs(sound).max(initial=0.0)
    if peak == 0:
        return 0.0
    resampled = soxr.resample(sound * (PEAK / peak), rate, SAMPLE_RATE)
    soundfile.write(path, resampled, SAMPLE_RATE, subtype="PCM_16")
    return len(resampled) / SAMPLE_RATE


if __name__ == "__main__":
    typer.run(main)
