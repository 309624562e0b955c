"""Whether the words of voz's lists, examples and documents are heard, each said alone.

Run `python benchmarks/words.py CLIPS [LIST...]`: speaks each word with twelve of Debian's synthetic
voices into the folder CLIPS, where they are not there yet, with a manifest. Then each word is a
command in a list of its like, and the words of the other lists are near-misses. Prints how many of
each word are right and accepted, and for each list how many of its words, and of the near-misses.
`--people MANIFEST` adds recordings of single words by people, of whom `--held-back` leaves only
those from whom the network learned nothing. `--save FILE` keeps what was heard, and `--before FILE`
puts such a file, by other code, beside it.
"""

from __future__ import annotations

import sys
from collections import defaultdict
from collections.abc import Iterable, Sequence
from pathlib import Path
from statistics import mean
from tempfile import TemporaryDirectory
from typing import Annotated
from zlib import crc32

import msgspec
import numpy as np
import soundfile
import typer
from machine import machine, one_line_errors
from mix_rooms import WORDS, is_held_back

from voz.api.recognizer import Recognizer
from voz.apps.recordings.manifest import MANIFEST_NAME, Clip, read_manifest
from voz.audio import SAMPLE_RATE
from voz.cli.text_io import with_bar
from voz.language.build import build
from voz.language.language_files import LanguageFiles
from voz.language.sentences.spelling import SMALL, TENS
from voz.settings import Recognition

sys.path.insert(0, str(Path(__file__).parent.parent / "tools"))

import synthesis  # a script beside the others

LISTS = {
    "single words": WORDS,
    "answers": "yes no again hover stop",
    "commands": (
        "start speech stop go forward back turn left right rotate speed up slow down point "
        "beer cocacola fold arm"
    ),
    "digits": " ".join(SMALL[:10]),
    "up to nineteen": " ".join(SMALL[10:]),
    "tens and parts": " ".join([*TENS, "hundred thousand minus point half quarter quarters"]),
    "drone": (
        "fly forward backward metre metres turn left right degrees climb take off land again "
        "hover start stop speech"
    ),
    "arm": (
        "please stop bring give red green deep blue cup key knife water bottle put table "
        "shelf open close gripper fold arm yes no start speech"
    ),
    "coffee": (
        "can may have get want give make brew small medium large ounce light dark roast "
        "single double triple shot americano cappuccino espresso latte iced mocha drip house "
        "coffee skim whole soy almond milk cream brown sugar sweetener some bit little lots"
    ),
    "home": (
        "on off up down lights blinds kitchen bedroom garage door lock unlock music volume "
        "louder pause play warmer cooler vacuum timer television dim open close"
    ),
    "documents": (
        "advance move drive quickly fetch wave self picture round light cola call come here "
        "home follow table around"
    ),
}
"""Words that voz gives a meaning to, in lists of their like.

Those that only join others (`a`, `the`, `with`) are left out: none is a command by itself.
"""

VOICES = synthesis.VOICES | {
    "espeak_scotland": synthesis.Voice.espeak("en-gb-scotland"),
    "espeak_rp_f3": synthesis.Voice.espeak("en-gb-x-rp+f3"),
    "espeak_us_f4": synthesis.Voice.espeak("en-us+f4"),
    "espeak_caribbean": synthesis.Voice.espeak("en-029+m5"),
    "espeak_nyc_m7": synthesis.Voice.espeak("en-us-nyc+m7"),
}

SAME = "flite_slt"
"""The same person as `festival_slt`."""

NEAR_MISSES = 200
"""Recordings of words of other lists that are heard with each list."""

QUIET = np.zeros(SAMPLE_RATE // 3, np.int16)
"""Put before and after recordings, some of which begin with their word."""


class Heard(msgspec.Struct, frozen=True):
    """What became of a recording: the commands that were accepted, and the surest text."""

    list: str
    word: str
    speaker: str
    accepted: tuple[str, ...]
    text: str

    @property
    def is_obeyed(self) -> bool:
        """Whether what was said was accepted, and nothing else."""
        return self.accepted == (self.word,)


def speak(folder: Path) -> Path:
    """Speak what is not yet in a folder; gives its manifest."""
    folder.mkdir(parents=True, exist_ok=True)
    synthesis.VOICES.update(VOICES)
    words = sorted({word for words in LISTS.values() for word in words.split()})
    lines = ["path\ttext\tspeaker\tkind\n"]
    for word in with_bar(words, "speaking"):
        for voice in sorted(VOICES.keys() - {SAME}):
            file = f"{voice}__{word}.flac"
            if not (folder / file).exists():
                noise = np.random.default_rng(crc32(file.encode()))
                sound = synthesis.with_floor(synthesis.phrase(voice, word), noise)
                soundfile.write(folder / file, sound, SAMPLE_RATE, subtype="PCM_16")
            lines.append(f"{file}\t{word}\t{voice}\tcommand\n")
    manifest = folder / MANIFEST_NAME
    manifest.write_text("".join(lines))
    return manifest


def hear(clips: Sequence[Clip], names: Sequence[str]) -> list[Heard]:
    """Hear each word in its lists, and some of the other words."""
    heard: list[Heard] = []
    for name in names:
        listed = LISTS[name]
        words = set(listed.split())
        with TemporaryDirectory() as folder:
            (Path(folder) / "words.txt").write_text("\n".join(sorted(words)))
            build(Path(folder) / "words.txt", Path(folder) / "lm")
            recognizer = Recognizer(LanguageFiles(Path(folder) / "lm"), Recognition())
            said = [clip for clip in clips if clip.text in words]
            others = [clip for clip in clips if clip.text not in words]
            some = sorted(others, key=lambda c: crc32(c.file.encode()))[:NEAR_MISSES]
            for clip in with_bar([*said, *some], name):
                heard.append(hear_one(recognizer, clip, name))
    return heard


def hear_one(recognizer: Recognizer, clip: Clip, name: str) -> Heard:
    """Hear one recording."""
    samples, _ = soundfile.read(clip.path, dtype="int16")
    found = recognizer.decode(np.concatenate([QUIET, samples, QUIET]), SAMPLE_RATE)
    text = max(found, key=lambda u: u.confidence).text if found else ""
    return Heard(name, clip.text, clip.speaker, tuple(u.text for u in found if u.accepted), text)


def grouped(heard: Iterable[Heard]) -> dict[tuple[str, str], list[Heard]]:
    """Put together what was heard of each word in a list."""
    found: dict[tuple[str, str], list[Heard]] = defaultdict(list)
    for one in heard:
        found[one.list, one.word].append(one)
    return found


def table(heard: Sequence[Heard], before: Sequence[Heard]) -> str:
    """Write how many recordings of each word are right, and accepted, before too."""
    now, earlier = grouped(heard), grouped(before)
    lines = [
        "| list | word | said | right | accepted before | accepted | not accepted from |",
        "|---|---|---|---|---|---|---|",
    ]
    for (name, word), said in now.items():
        if word not in LISTS[name].split():
            continue
        was = earlier.get((name, word))
        shares = [
            f"{mean(one.text == word for one in said):.2f}",
            f"{mean(one.is_obeyed for one in was):.2f}" if was else "",
            f"{mean(one.is_obeyed for one in said):.2f}",
        ]
        missed = ", ".join(sorted({one.speaker for one in said if not one.is_obeyed})[:6])
        lines.append(f"| {name} | {word} | {len(said)} | {' | '.join(shares)} | {missed} |")
    return "\n".join(lines)


def totals(heard: Sequence[Heard], before: Sequence[Heard]) -> str:
    """Write what each list takes of its words, and of those of other lists."""
    lines = [
        "| list | said | right and accepted | near-misses | let through before | now |",
        "|---|---|---|---|---|---|",
    ]
    for name, words in LISTS.items():
        of_list = [one for one in heard if one.list == name]
        own = [one.is_obeyed for one in of_list if one.word in words.split()]
        if not own:
            continue
        then, now = (
            [bool(h.accepted) for h in each if h.list == name and h.word not in words.split()]
            for each in (before, heard)
        )
        figures = f"{len(own)} | {mean(own):.3f} | {len(now)} | {sum(then) if then else ''}"
        lines.append(f"| {name} | {figures} | {sum(now)} |")
    return "\n".join(lines)


def main(
    clips: Annotated[Path, typer.Argument(help="Folder of the words that are spoken.")],
    names: Annotated[list[str] | None, typer.Argument(metavar="LIST...", help="Else all.")] = None,
    people: Annotated[list[Path], typer.Option(help="Manifest of words by people.")] = [],  # noqa: B006
    save: Annotated[Path | None, typer.Option(help="Keep what was heard here.")] = None,
    before: Annotated[Path | None, typer.Option(help="What other code heard.")] = None,
    held_back: Annotated[bool, typer.Option(help="Only speakers never learned from.")] = False,
) -> None:
    """Print what is heard of each word.

    Example: python benchmarks/words.py clips "single words" --people mine/manifest.tsv
    """
    if unknown := {*(names or ())} - {*LISTS}:
        raise typer.BadParameter(f"no list {min(unknown)}; there are {', '.join(LISTS)}")
    spoken = [clip for path in (speak(clips), *people) for clip in read_manifest(path)]
    spoken = [clip for clip in spoken if not held_back or is_held_back(clip.speaker)]
    of_words = [c for c in spoken if c.kind in ("command", "near-miss") and c.text]
    heard = hear(of_words, names or [*LISTS])
    earlier = msgspec.json.decode(before.read_bytes(), type=list[Heard]) if before else []
    if save:
        save.write_bytes(msgspec.json.encode(heard))
    print(machine())
    print(f"\n{table(heard, earlier)}\n\n{totals(heard, earlier)}")


if __name__ == "__main__":
    with one_line_errors():
        typer.run(main)
