"""How well another language is understood: the 14 commands of `examples/spanish` by espeak-ng.

Run `python benchmarks/language.py DIR` on a copy of CMUSphinx's Spanish model and dictionary. Each
command is said by each voice, and so are sentences that are no commands but sound like some.
"""

from __future__ import annotations

import os
import subprocess
import tempfile
from collections import Counter
from collections.abc import Iterator, Sequence
from itertools import product
from pathlib import Path
from typing import Annotated, NamedTuple

import numpy as np
import soundfile
import soxr
import typer
from machine import machine

from voz.api.recognizer import Recognizer
from voz.audio import Samples
from voz.audio.sound_files import to_int16
from voz.config import load_config
from voz.language.build import build
from voz.language.command_source import read_list
from voz.language.language_files import LanguageFiles
from voz.language.spoken_language import add_language, find_sources, read_language
from voz.recognition.engine import confidence_model
from voz.recognition.thresholds import thresholds_of
from voz.settings import Recognition

SPANISH = Path(__file__).parent.parent / "examples" / "spanish"

NEAR_MISSES = (
    "gira",
    "escucha la radio",
    "deja de hablar",
    "empieza a cantar",
    "la cerveza",
    "señala la puerta",
    "recoge la mesa",
    "más rápido",
    "para qué sirve",
    "espera un momento",
    "avanzamos mucho",
    "a la derecha",
    "rota el papel",
    "más despacio no se puede",
    "la izquierda gana",
    "compra el brazo",
    "acelerador",
    "buenos días",
    "qué hora es",
    "parada",
)
"""None of them a command; many begin or end as one."""


THRESHOLDS = (0.1, 0.2, 0.3, 0.5, 0.7)


class Voice(NamedTuple):
    """A voice of espeak-ng, its pitch (0 to 99) and words a minute."""

    name: str
    pitch: int
    speed: int


VOICES = [
    Voice(f"{language}{variant}", pitch, speed)
    for (language, variant), (pitch, speed) in product(
        product(("es", "es-419"), ("", "+f3")), ((50, 130), (50, 165), (80, 150))
    )
]


def spoken(text: str, voice: Voice, folder: Path) -> Samples:
    """Let a voice say a text, with half a second of a quiet room before and behind it."""
    wav = folder / "said.wav"
    how = ["-v", voice.name, "-p", str(voice.pitch), "-s", str(voice.speed), "-w", str(wav)]
    subprocess.run(["espeak-ng", *how, "--stdin"], input=text.encode(), check=True)
    sound, rate = soundfile.read(wav, dtype="float32")
    quiet = np.zeros(8000, np.float32)
    loud = np.concatenate([quiet, soxr.resample(sound, rate, 16000) * 0.5, quiet])
    room = np.random.default_rng(0).normal(0, 3e-4, len(loud))
    return to_int16(loud + room)


def built(given: Path, folder: Path) -> LanguageFiles:
    """Make the language files of the example with a copy of a language."""
    os.environ["XDG_DATA_HOME"] = str(folder)
    add_language(given, "es")
    os.chdir(SPANISH)  # its settings name the rules from there
    sources = find_sources(load_config(Path("voz.toml")).language)
    assert sources
    commands = Path("comandos.txt")
    build(commands, folder / "lm", read_list(commands, read_language(sources)))
    return LanguageFiles(folder / "lm")


class Said(NamedTuple):
    """A text that was said, what was heard, how surely, and whether it was obeyed."""

    text: str
    heard: str
    confidence: float
    obeyed: bool

    @property
    def is_right(self) -> bool:
        """Whether it was understood."""
        return self.text == self.heard


def judged(
    recognizer: Recognizer, texts: Sequence[str], voices: Sequence[Voice], folder: Path
) -> list[Said]:
    """Let all voices say all texts."""
    found = []
    for voice, text in product(voices, texts):
        heard = list(recognizer.utterances([spoken(text, voice, folder)], ""))
        words = " / ".join(u.text for u in heard)
        sure = max((u.confidence for u in heard), default=0.0)
        found.append(Said(text, words, sure, any(u.accepted for u in heard)))
    return found


def report(commands: Sequence[Said], others: Sequence[Said]) -> Iterator[str]:
    """The figures, a line each."""
    right = [said for said in commands if said.is_right]
    obeyed = sum(said.obeyed for said in right)
    wrongly = sum(said.obeyed for said in commands if not said.is_right)
    refused = sum(not said.obeyed for said in others)
    yield f"commands: {len(right)} of {len(commands)} right, {obeyed} right and accepted,"
    yield f"  {wrongly} taken for another and accepted"
    yield f"near-misses: {refused} of {len(others)} refused"
    for least in THRESHOLDS:
        kept = sum(said.confidence >= least for said in right)
        more = sum(said.confidence < least for said in others)
        yield f"  at threshold {least}: {kept} right and accepted, {more} near-misses refused"
    lost = Counter(said.text for said in commands if not (said.is_right and said.obeyed))
    yield "lost most: " + ", ".join(f"{text} {count}" for text, count in lost.most_common(5))


def main(
    folder: Annotated[Path, typer.Argument(metavar="DIR", help="A model and a dictionary.")],
    every: Annotated[bool, typer.Option("--all", help="Show each one that went wrong.")] = False,
    most: Annotated[
        int, typer.Option("--voices", metavar="N", min=1, help="The first so many voices alone.")
    ] = len(VOICES),
) -> None:
    """Print how many commands are right, how many of them are obeyed, and near-misses too."""
    settings = Recognition(never_missed=("para",))
    with tempfile.TemporaryDirectory(prefix="voz-") as work:
        files = built(folder.resolve(), Path(work))
        recognizer = Recognizer(files, settings)
        least = thresholds_of(confidence_model(recognizer), settings)
        voices = VOICES[:most]
        print(
            f"{machine()}; {len(voices)} of {len(VOICES)} voices; accepted from {least.usual:.2f}"
        )
        commands = judged(recognizer, recognizer.commands.listed, voices, Path(work))
        others = judged(recognizer, NEAR_MISSES, voices, Path(work))
    for line in report(commands, others):
        print(line)
    for said in [*commands, *others] if every else ():
        if said.is_right != said.obeyed:
            print(f"{said.text}: {said.heard} {said.confidence}", "accepted" * said.obeyed)


if __name__ == "__main__":
    typer.run(main)
