"""English phrases of common words by Kokoro's voices, half of them in pairs one phone apart.

    python training/english_words.py OUT --kokoro FOLDER

A phrase and the same with one word replaced by its neighbor ("fold arm", "cold arm") are read by
one voice. Voices are also mixed, two at a time, and those of other languages read English, too.
"""

from __future__ import annotations

import csv
import random
from collections.abc import Collection, Mapping, Sequence
from itertools import cycle, islice
from pathlib import Path
from typing import Annotated, NamedTuple

import typer
from phrases import choose_phrases, one_phone_apart, with_word
from synthesize import common_words, usual_phones

from voz.cli.text_io import with_bar
from voz.language.espeak import written_by_espeak
from voz.language.sentences.text_lines import content_lines

WORDS = 6000
"""So many of the commonest are read."""

MOST_SYLLABLES = 3

MOST_PHONES = 5
"""Of a word that stands in the place of a command's."""

ENGLISH = 0.5
"""How often a voice is an English one."""

SPEEDS = (0.85, 1.35)

LETTERS = Path(__file__).with_name("kokoro_phones.tsv")
"""How Kokoro writes the phones of CMUdict; only vowels have letters without stress."""

STRESS = "\u02c8"

ESPEAK_VOWELS = frozenset("aeiouæɐɑɒɔəɚɛɜɪʊʌᵻ")  # noqa: RUF001


class Word(NamedTuple):
    """A word's phones in CMUdict, and how Kokoro reads it."""

    phones: str
    letters: str


def main(
    out: Annotated[Path, typer.Argument(help="Folder of the recordings and their manifest.tsv.")],
    kokoro: Annotated[Path, typer.Option(help="Folder of Kokoro's files.")] = Path("kokoro"),
    commands: Annotated[
        Path | None,
        typer.Option(
            help="A list that was taught before: its commands are read with another word in each, "
            "so that one word does not tell the rest.",
        ),
    ] = None,
    texts: Annotated[
        Path | None,
        typer.Option(help="Columns text and kind: read to score, by voices that teach nothing."),
    ] = None,
    clips: Annotated[int, typer.Option(min=1, help="How many recordings.")] = 2000,
    seed: Annotated[int, typer.Option(help="Of the choice of words and voices.")] = 1,
) -> None:
    """Have Kokoro's voices read words and short phrases of English.

    Example: python training/english_words.py english --clips 2000
    """
    from foreign_words import write  # who only chooses words needs none of what these need
    from kokoro import RATE, Kokoro, choose_voices, speaker_of

    (out / "clips").mkdir(parents=True, exist_ok=True)
    rng = random.Random(seed)
    engine = Kokoro(kokoro, kept_aside=texts is not None)
    kinds = kinds_of(texts) if texts else {}
    own = [text.split() for text in kinds]
    listed = {word for phrase in own for word in phrase}
    words = readable(usual_phones(listed) if texts else common_words(WORDS))
    groups: Sequence[Sequence[Sequence[str]]]
    if texts:
        groups = [(phrase,) for phrase in islice(cycle(own), clips) if words.keys() >= {*phrase}]
    elif commands:
        lines = content_lines(commands.read_bytes(), str(commands))
        groups = otherwise([line.split() for _, line in lines], words, clips, rng)
    else:
        groups = choose_phrases(neighbors(words), clips, rng)
    with (out / "manifest.tsv").open("w", encoding="utf-8", newline="") as file:
        table = csv.writer(file, delimiter="\t", lineterminator="\n")
        table.writerow(("path", "text", "kind", "phones", "exact", "speaker", "seconds"))
        for number, group in enumerate(with_bar(groups, "Reading")):
            voices = choose_voices(engine.voices, "ab", ENGLISH, rng, mixed=texts is None)
            speed = rng.uniform(*SPEEDS)
            for place, phrase in enumerate(group):
                path = out / "clips" / f"{number:05}-{place}.flac"
                text, letters, phones = read_as(phrase, words)
                seconds = write(path, engine.read(f"{letters}.", voices, speed), RATE)
                if seconds:
                    known = (text, kinds.get(text, "words"), phones, "yes", speaker_of(voices))
                    table.writerow((path.relative_to(out), *known, f"{seconds:.2f}"))
            file.flush()


def read_as(phrase: Sequence[str], words: Mapping[str, Word]) -> tuple[str, str, str]:
    """The text of a phrase, as Kokoro reads it, and its phones."""
    letters = " ".join(words[word].letters for word in phrase)
    return " ".join(phrase), letters, " ".join(words[word].phones for word in phrase)


def kinds_of(path: Path) -> dict[str, str]:
    """The texts of a table, each with its kind."""
    with path.open(encoding="utf-8", newline="") as file:
        return {row["text"]: row["kind"] for row in csv.DictReader(file, delimiter="\t")}


def readable(known: dict[str, str]) -> dict[str, Word]:
    """Short words whose stress espeak-ng tells."""
    with LETTERS.open(encoding="utf-8", newline="") as file:
        letters = {row["phone"]: row for row in csv.DictReader(file, delimiter="\t")}
    written = written_by_espeak([*known], "en-us")
    found = {}
    for (text, phones), line in zip(known.items(), written, strict=True):
        spelled = [letters[phone] for phone in phones.split()]
        syllables = sum(bool(each["unstressed"]) for each in spelled)
        stressed = [STRESS in part for part in line.split("_") if ESPEAK_VOWELS.intersection(part)]
        if len(stressed) == syllables <= MOST_SYLLABLES and any(stressed):
            found[text] = Word(phones, read_aloud(spelled, stressed))
    return found


def read_aloud(spelled: Sequence[Mapping[str, str]], stressed: Sequence[bool]) -> str:
    """A word as Kokoro reads it, by the letters of its phones and the stress of its vowels."""
    letters, stresses = "", iter(stressed)
    for phone in spelled:
        is_vowel = bool(phone["unstressed"])
        if is_vowel and not next(stresses):
            letters += phone["unstressed"]
        else:
            letters += STRESS * is_vowel + phone["letters"]
    return letters


def neighbors(words: Mapping[str, Word]) -> dict[str, list[str]]:
    """The words that are one phone apart from each."""
    return one_phone_apart({text: word.phones.split() for text, word in words.items()})


def otherwise(
    commands: Collection[Sequence[str]],
    words: Mapping[str, Word],
    clips: int,
    rng: random.Random,
) -> list[tuple[Sequence[str], ...]]:
    """Choose commands, so many in all, each with one word replaced by a short one.

    That sounds like no word of the list, nor is it one phone away from one: neither the commands
    nor their neighbors are taught.
    """
    near = neighbors(words)
    own = {word for command in commands for word in command} & words.keys()
    sounds = {words[word].phones for word in own}
    others = [
        text
        for text, word in words.items()
        if len(word.phones.split()) <= MOST_PHONES
        and word.phones not in sounds
        and own.isdisjoint(near[text])
    ]
    usable = [command for command in commands if len(command) > 1 and words.keys() >= {*command}]
    found = []
    for _ in range(clips):
        command = rng.choice(usable)
        found.append((with_word(command, rng.randrange(len(command)), rng.choice(others)),))
    return found


if __name__ == "__main__":
    typer.run(main)
