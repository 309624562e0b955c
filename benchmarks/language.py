"""How well another language is understood: the 14 commands of `examples/spanish` by espeak-ng.

Run `python benchmarks/language.py DIR` on a copy of CMUSphinx's Spanish model and dictionary. Each
command is said by each voice, and so are sentences that are no commands but sound like some.
"""

from __future__ import annotations

import os
import subprocess
import tempfile
from collections import Counter
from collections.abc import Iterator
from itertools import product
from pathlib import Path
from typing import Annotated, NamedTuple

import numpy as np
import soundfile
import soxr
import typer
from machine import machine

from voz.audio import Samples
from voz.audio.capture.files import to_int16
from voz.config import Recognition, load_config
from voz.language.build import build, read_list
from voz.language.files import LanguageFiles
from voz.language.languages import add_language, read_language, sources_of
from voz.recognition.interpreter import thresholds
from voz.recognition.recognizer import Recognizer

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
    sources = sources_of(load_config(Path("voz.toml")).language)
    assert sources
    commands = Path("comandos.txt")
    build(commands, folder / "lm", read_list(commands, read_language(sources)))
    return LanguageFiles(folder / "lm")


def judged(recognizer: Recognizer, texts: list[str], folder: Path) -> Iterator[tuple[str, str, list[float], bool]]:
    """Each text with what was heard, how surely, and whether it was obeyed."""
    for voice in VOICES:
        for text in texts:
            heard = list(recognizer.utterances([spoken(text, voice, folder)], ""))
            said = " / ".join(u.text for u in heard)
            yield text, said, [u.confidence for u in heard], any(u.accepted for u in heard)


def main(
    folder: Annotated[Path, typer.Argument(metavar="DIR", help="A model and a dictionary.")],
    every: Annotated[bool, typer.Option("--all", help="Show each one that went wrong.")] = False,
) -> None:
    """Print how many commands are right, how many of them are obeyed, and near-misses too."""
    with tempfile.TemporaryDirectory(prefix="voz-") as work:
        files = built(folder.resolve(), Path(work))
        recognizer = Recognizer(files, Recognition(never_missed=("para",)))
        commands = list(recognizer.commands)
        needed = set(thresholds(recognizer.model, Recognition(), commands).values())
        print(f"{machine()}; {len(VOICES)} voices; confidence needed: {max(needed):.2f}")
        found = list(judged(recognizer, commands, Path(work)))
        missed = list(judged(recognizer, list(NEAR_MISSES), Path(work)))
    right = [f for f in found if f[0] == f[1]]
    obeyed = [f for f in right if f[3]]
    wrongly = [f for f in found if f[0] != f[1] and f[3]]
    through = [f for f in missed if f[3]]
    print(f"commands: {len(right)} of {len(found)} right, {len(obeyed)} right and accepted,")
    print(f"  {len(wrongly)} taken for another and accepted")
    print(f"near-misses: {len(missed) - len(through)} of {len(missed)} refused")
    lost = Counter(f[0] for f in found if f not in obeyed)
    print("lost most:", ", ".join(f"{text} {count}" for text, count in lost.most_common(5)))
    for threshold in (0.2, 0.3, 0.4, 0.5, 0.6, 0.7, 0.8):
        kept = sum(f[0] == f[1] and max(f[2], default=0) >= threshold for f in found)
        more = sum(max(f[2], default=0) >= threshold for f in missed)
        print(f"threshold {threshold}: {kept / len(found):.3f} right and accepted, {more} near-misses")
    if every:
        for text, said, sure, accepted in [*found, *missed]:
            if (text == said) != accepted:
                print(f"{text}: {said or 'nothing'} {sure} {'accepted' if accepted else ''}")


if __name__ == "__main__":
    typer.run(main)
