"""Words and phrases of other languages by synthetic voices, with their phones, to learn from.

    python training/foreign_words.py OUT --engine espeak

espeak-ng tells the phones of what is read. The voices are its own, SVOX Pico's (PyPI's
`py-nanotts`), or Kokoro's, any of which reads any language's phones.
"""

from __future__ import annotations

import csv
import random
import subprocess
import tempfile
from collections.abc import Callable
from enum import Enum
from pathlib import Path
from typing import Annotated, NamedTuple

import numpy as np
import soundfile
import soxr
import typer
from noises import Sound
from wordfreq import top_n_list

from voz.audio import SAMPLE_RATE
from voz.cli.text_io import with_bar
from voz.language.espeak import TIME_LIMIT, run_espeak
from voz.language.ipa import known_phones

ACCENTS = {
    "es": ("es", "es-419"),
    "fr": ("fr",),
    "it": ("it",),
    "de": ("de",),
    "pt": ("pt", "pt-br"),
}
"""Of each language, as espeak-ng names them."""

SHARES = {"es": 3, "fr": 4, "it": 1, "de": 1, "pt": 1}
"""How often each language is drawn."""

COMMON_WORDS = 8000
"""Words of a language that are read."""

LENGTHS = (1, 1, 1, 2, 2, 3, 4)
"""Words in a phrase."""

PEAK = 0.5

ESPEAK_VARIANTS = (*(f"m{n}" for n in range(1, 9)), *(f"f{n}" for n in range(1, 6)))

PICO_VOICES = {"es": "es-ES", "fr": "fr-FR", "it": "it-IT", "de": "de-DE"}

KOKORO_NATIVES = {"es": "e", "fr": "f", "it": "i", "pt": "p"}
"""The letter that the voices of each language begin with; German has none."""

NATIVE_SHARE = 0.4
"""How often a language is read by a voice of its own."""


class Phrase(NamedTuple):
    """Words to read.

    Attributes:
        text: the words.
        language: one of `ACCENTS`.
        accent: of espeak-ng, by whose rules it is read.
        phones: as `voz.language.ipa` names them.
        stressed: the same as espeak-ng writes them, with stress.
    """

    text: str
    language: str
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
    clips: Annotated[int, typer.Option(min=1, help="How many recordings.")] = 2000,
    seed: Annotated[int, typer.Option(help="Of the choice of words and voices.")] = 1,
) -> None:
    """Have voices read words and short phrases of Spanish, French, Italian, German, Portuguese.

    Example: python training/foreign_words.py espeak --clips 2000
    """
    (out / "clips").mkdir(parents=True, exist_ok=True)
    rng = random.Random(seed)
    languages = [*(PICO_VOICES if engine is Engine.PICO else ACCENTS)]
    read = reader(engine, kokoro)
    with (out / "manifest.tsv").open("w", encoding="utf-8", newline="") as file:
        table = csv.writer(file, delimiter="\t", lineterminator="\n")
        table.writerow(("path", "text", "language", "phones", "speaker", "seconds"))
        for number, phrase in enumerate(with_bar(phrases(languages, clips, rng), "Reading")):
            voice, sound, rate = read(phrase, rng)
            path = out / "clips" / f"{number:05}.flac"
            seconds = write(path, sound, rate)
            if seconds:
                row = (phrase.text, phrase.language, phrase.phones, voice, f"{seconds:.2f}")
                table.writerow((path.relative_to(out), *row))
                file.flush()


def phrases(languages: list[str], count: int, rng: random.Random) -> list[Phrase]:
    """Choose phrases of common words, and have espeak-ng tell their phones."""
    words = {
        language: [word for word in top_n_list(language, COMMON_WORDS) if word.isalpha()]
        for language in languages
    }
    texts: dict[str, list[tuple[str, str]]] = {}
    drawn = rng.choices(languages, [SHARES[language] for language in languages], k=count)
    for language in drawn:
        text = " ".join(rng.choices(words[language], k=rng.choice(LENGTHS)))
        texts.setdefault(rng.choice(ACCENTS[language]), []).append((text, language))
    found = []
    for accent, chosen in texts.items():
        plain = run_espeak([text for text, _ in chosen], accent)
        stressed = with_stress([text for text, _ in chosen], accent)
        found += [
            Phrase(text, language, accent, plain[text], with_signs)
            for (text, language), with_signs in zip(chosen, stressed, strict=True)
            if known_phones().issuperset(plain[text].split())
        ]
    rng.shuffle(found)
    return found


def with_stress(texts: list[str], accent: str) -> list[str]:
    """The phones of texts as espeak-ng writes them, with stress."""
    command = ["espeak-ng", "-q", "-b", "1", "--ipa", "-v", accent]
    text = "".join(f"{text}\n" for text in texts)
    done = subprocess.run(
        command, input=text, capture_output=True, encoding="utf-8", timeout=TIME_LIMIT, check=True
    )
    return done.stdout.splitlines()


def reader(engine: Engine, kokoro: Path) -> Reader:
    """What reads phrases by the voices of an engine."""
    if engine is Engine.KOKORO:
        return kokoro_reader(kokoro)
    return pico_reader() if engine is Engine.PICO else read_by_espeak


def read_by_espeak(phrase: Phrase, rng: random.Random) -> tuple[str, Sound, int]:
    """Read by a variant of espeak-ng's voice."""
    variant = rng.choice(ESPEAK_VARIANTS)
    speed, pitch = rng.randint(120, 210), rng.randint(25, 75)
    with tempfile.NamedTemporaryFile(suffix=".wav") as file:
        options = ["-v", f"{phrase.accent}+{variant}", "-s", str(speed), "-p", str(pitch)]
        command = ["espeak-ng", *options, "-w", file.name, "--stdin"]
        subprocess.run(command, input=phrase.text, encoding="utf-8", timeout=TIME_LIMIT, check=True)
        sound, rate = soundfile.read(file.name, dtype="float32")
    return f"espeak-{phrase.accent}-{variant}", sound, rate


def pico_reader() -> Reader:
    """Reads by the voice of Pico that a language has."""
    from py_nanotts import NanoTTS  # who reads by another engine needs it not

    nano = NanoTTS()

    def read(phrase: Phrase, rng: random.Random) -> tuple[str, Sound, int]:
        voice, speed, pitch = (
            PICO_VOICES[phrase.language],
            rng.uniform(0.8, 1.2),
            rng.uniform(0.8, 1.2),
        )
        pcm = nano.speak(f"{phrase.text}.", voice, speed, pitch)
        return f"pico-{voice}", np.frombuffer(pcm, np.int16).astype(np.float32) / 32768, SAMPLE_RATE

    return read


def kokoro_reader(folder: Path) -> Reader:
    """Reads by Kokoro's voices, by those of the language more often."""
    from kokoro import Kokoro

    engine = Kokoro(folder)

    def read(phrase: Phrase, rng: random.Random) -> tuple[str, Sound, int]:
        letter = KOKORO_NATIVES.get(phrase.language, "none")
        natives = [voice for voice in engine.voices if voice.startswith(letter)]
        voice = rng.choice(natives if natives and rng.random() < NATIVE_SHARE else engine.voices)
        sound = engine.read(f"{phrase.stressed}.", voice, rng.uniform(0.8, 1.2))
        return f"kokoro-{voice}", sound, 24_000

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
