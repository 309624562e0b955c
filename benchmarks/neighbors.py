"""How often a phrase that is one phone away from a command is obeyed: "cold arm" for "fold arm".

Run `python benchmarks/neighbors.py FOLDER`: replaces a word of each command by words of everyday
English that are one phone away, and speaks these neighbors and the commands with Debian's synthetic
voices into FOLDER, where they are not there yet, with a manifest. If FOLDER has a manifest already,
its recordings are used as they are: other voices, or people. `--lm` takes another list; `--ways 5`
says how many neighbors a command has. Prints what is right and accepted, what is obeyed of the
neighbors, and how many commands are accepted where 1, 5 and 10 in 100 neighbors get through, and
how many are accepted or asked back, by the number of words and of phones.
"""

from __future__ import annotations

import random
import sys
from collections.abc import Callable, Iterable, Sequence
from pathlib import Path
from statistics import mean
from typing import Annotated, NamedTuple
from zlib import crc32

import numpy as np
import pocketsphinx
import soundfile
import typer
from machine import machine, one_line_errors

from voz.api.recognizer import Recognizer
from voz.apps.recordings.manifest import MANIFEST_NAME, Clip, read_manifest
from voz.audio import SAMPLE_RATE
from voz.cli.text_io import with_bar
from voz.language.language_files import find_language
from voz.recognition.language import Language, load_language
from voz.recognition.thresholds import asked_from
from voz.settings import Recognition

sys.path.insert(0, str(Path(__file__).parent.parent / "tools"))

import synthesis  # a script beside the others

VOICES = ("festival_slt", "flite_rms", "flite_awb", "espeak_us", "espeak_gb")

MIN_LOG_PROBABILITY = -132_000
"""Of a word of everyday English by pocketsphinx's trigram model, in units of its logarithm."""

LET_THROUGH = (0.01, 0.05, 0.1)


class Heard(NamedTuple):
    """What became of a recording."""

    clip: Clip
    confidence: float  # of the command, or of any if another phrase was said
    obeyed: bool


def everyday() -> Callable[[str], bool]:
    """Whether a word is one of everyday English, as a function."""
    path = pocketsphinx.get_model_path("en-us/en-us.lm.bin")
    model = pocketsphinx.NGramModel(pocketsphinx.Config(lm=None), pocketsphinx.LogMath(), path)
    return lambda word: bool(model.prob([word]) > MIN_LOG_PROBABILITY)


def neighbors(language: Language, ways: int) -> list[str]:
    """Sentences with one word one phone away, so many of each command; the same each time."""
    is_everyday = everyday()
    found: dict[str, None] = {}
    for command in language.commands.examples():
        words = command.split()
        near = [
            " ".join([*words[:place], other, *words[place + 1 :]])
            for place, word in enumerate(words)
            for names in language.rivals.get(word, {}).values()
            for other in names
            if is_everyday(other)
        ]
        none = [text for text in near if text not in language.commands]
        random.Random(command).shuffle(none)
        found.update(dict.fromkeys(none[:ways]))
    return list(found)


def speak(folder: Path, commands: Iterable[str], phrases: Iterable[str]) -> Path:
    """Speak commands and neighbors into a folder that has no manifest; gives its manifest."""
    manifest = folder / MANIFEST_NAME
    if manifest.exists():
        return manifest
    folder.mkdir(parents=True, exist_ok=True)
    rows = [(text, "command") for text in commands] + [(text, "near-miss") for text in phrases]
    lines = ["path\ttext\tspeaker\tkind\n"]
    for text, kind in with_bar(rows, "speaking"):
        for voice in VOICES:
            file = f"{voice}__{text.replace(' ', '_')}.flac"
            noise = np.random.default_rng(crc32(file.encode()))
            sound = synthesis.with_floor(synthesis.phrase(voice, text), noise)
            soundfile.write(folder / file, sound, SAMPLE_RATE, subtype="PCM_16")
            lines.append(f"{file}\t{text}\t{voice}\t{kind}\n")
    manifest.write_text("".join(lines))
    return manifest


def hear(recognizer: Recognizer, clip: Clip) -> Heard:
    """Hear one recording."""
    found = recognizer.decode(str(clip.path))
    counted = [u for u in found if clip.kind != "command" or u.text == clip.text]
    accepted = [u.text for u in found if u.accepted]
    obeyed = accepted == [clip.text] if clip.kind == "command" else bool(accepted)
    return Heard(clip, max((u.confidence for u in counted), default=0.0), obeyed)


def curve(heard: Sequence[Heard]) -> list[str]:
    """The counts, and where some neighbors get through, the commands accepted / or asked back."""
    commands = [each.confidence for each in heard if each.clip.kind == "command"]
    others = sorted((e.confidence for e in heard if e.clip.kind != "command"), reverse=True)
    if not commands or not others:
        return [str(len(commands)), str(len(others)), *[""] * len(LET_THROUGH)]
    needed = [others[int(share * len(others))] for share in LET_THROUGH]
    shares = [
        " / ".join(f"{mean(c > least for c in commands):.3f}" for least in (t, asked_from(t)))
        for t in needed
    ]
    return [str(len(commands)), str(len(others)), *shares]


def table(heard: Sequence[Heard], phones_of: Callable[[str], int]) -> str:
    """The curve of all recordings, of those of so many words, and of so many phones."""
    groups: dict[str, Callable[[str], bool]] = {"all": lambda _: True}
    groups["1 word"] = lambda text: len(text.split()) == 1
    groups["2 words and more"] = lambda text: len(text.split()) > 1
    groups["up to 6 phones"] = lambda text: phones_of(text) <= 6
    groups["7 phones and more"] = lambda text: phones_of(text) > 6
    through = " | ".join(f"accepted / or asked at {share:.0%}" for share in LET_THROUGH)
    lines = [f"| | commands | neighbors | {through} |", "|---|---|---|" + "---|" * len(LET_THROUGH)]
    for name, belongs in groups.items():
        lines.append(
            f"| {name} | {' | '.join(curve([h for h in heard if belongs(h.clip.text)]))} |"
        )
    return "\n".join(lines)


def main(
    folder: Annotated[Path, typer.Argument(help="Of the recordings; with a manifest, or new.")],
    lm: Annotated[str | None, typer.Option(help="Folder of the language files.")] = None,
    ways: Annotated[int, typer.Option(help="Neighbors of each command.", min=1)] = 5,
) -> None:
    """Print what is obeyed of phrases that are one phone away from a command.

    Example: python benchmarks/neighbors.py neighbors
    """
    files = find_language(lm)
    language = load_language(files)
    phrases = neighbors(language, ways)
    manifest = speak(folder, language.commands.examples(), phrases)
    recognizer = Recognizer(files, Recognition())
    heard = [hear(recognizer, clip) for clip in with_bar(read_manifest(manifest), "hearing")]
    right = [each.obeyed for each in heard if each.clip.kind == "command"]
    wrong = [each.obeyed for each in heard if each.clip.kind != "command"]
    print(machine())
    print(f"\nright and accepted {mean(right):.3f} of {len(right)} commands")
    print(f"obeyed {mean(wrong):.3f} of {len(wrong)} neighbors\n")
    spelled = {word: len(phones) for word, phones in language.dictionary.items()}
    print(table(heard, lambda text: sum(spelled.get(word, 4) for word in text.split())))


if __name__ == "__main__":
    with one_line_errors():
        typer.run(main)
