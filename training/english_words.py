"""English phrases of common words by Kokoro's voices, half of them in pairs one phone apart.

    python training/english_words.py OUT --kokoro FOLDER

A phrase and the same with one word replaced by its neighbor ("fold arm", "cold arm") are read by
one voice. Voices are also mixed, two at a time, and those of other languages read English, too.
"""

from __future__ import annotations

import csv
import random
from collections.abc import Collection, Mapping, Sequence
from pathlib import Path
from typing import Annotated, NamedTuple, TypeAlias

import typer
from synthesize import common_words

from voz.cli.text_io import with_bar
from voz.language.espeak import written_by_espeak
from voz.language.pronunciation import read_cmudict
from voz.language.sentences.text_lines import content_lines
from voz.language.word_neighbors import Rivals, find_rivals

WORDS = 6000
"""So many of the commonest are read."""

MOST_SYLLABLES = 3

MOST_PHONES = 5
"""Of a word that stands in the place of a command's."""

LENGTHS = (1, 1, 2, 2, 2, 3)
"""Words in a phrase."""

PAIRS = 0.5
"""How many of the phrases are read a second time with a neighbor in the place of a word."""

MIXED, ENGLISH = 0.3, 0.5
"""How often two voices are mixed, and how often one voice is an English one."""

SPEEDS = (0.85, 1.35)

LETTERS = Path(__file__).with_name("kokoro_phones.tsv")
"""How Kokoro writes the phones of CMUdict; only vowels have letters without stress."""

STRESS = "\u02c8"

ESPEAK_VOWELS = frozenset("aeiouæɐɑɒɔəɚɛɜɪʊʌᵻ")  # noqa: RUF001


class Word(NamedTuple):
    """A word, its phones in CMUdict, and as Kokoro reads it."""

    text: str
    phones: str
    letters: str


Phrase: TypeAlias = Sequence[Word]


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
    clips: Annotated[int, typer.Option(min=1, help="How many recordings.")] = 2000,
    seed: Annotated[int, typer.Option(help="Of the choice of words and voices.")] = 1,
) -> None:
    """Have Kokoro's voices read words and short phrases of English.

    Example: python training/english_words.py english --clips 2000
    """
    from foreign_words import write  # who only chooses words needs none of what these need
    from kokoro import RATE, Kokoro

    (out / "clips").mkdir(parents=True, exist_ok=True)
    rng = random.Random(seed)
    engine = Kokoro(kokoro)
    words = readable(common_words(WORDS))
    rivals = find_rivals({word.text: {word.phones} for word in words}, read_cmudict())
    if commands:
        lines = content_lines(commands.read_bytes(), str(commands))
        listed = [line.split() for _, line in lines]
        groups = otherwise(listed, words, rivals, clips, rng)
    else:
        groups = phrases(words, rivals, clips, rng)
    with (out / "manifest.tsv").open("w", encoding="utf-8", newline="") as file:
        table = csv.writer(file, delimiter="\t", lineterminator="\n")
        table.writerow(("path", "text", "phones", "exact", "speaker", "seconds"))
        number = 0
        for group in with_bar(groups, "Reading"):
            voices, speed = voices_for(engine.voices, rng), rng.uniform(*SPEEDS)
            for phrase in group:
                path = out / "clips" / f"{number:05}.flac"
                letters = " ".join(word.letters for word in phrase)
                seconds = write(path, engine.read(f"{letters}.", voices, speed), RATE)
                if not seconds:
                    continue
                text = " ".join(word.text for word in phrase)
                phones = " ".join(word.phones for word in phrase)
                speaker = "Kokoro-" + "+".join(voices)
                row = (path.relative_to(out), text, phones, "yes", speaker, f"{seconds:.2f}")
                table.writerow(row)
                number += 1
            file.flush()


def readable(known: dict[str, str]) -> list[Word]:
    """Short words whose stress espeak-ng tells."""
    with LETTERS.open(encoding="utf-8", newline="") as file:
        letters = {row["phone"]: row for row in csv.DictReader(file, delimiter="\t")}
    written = written_by_espeak([*known], "en-us")
    found = []
    for (text, phones), line in zip(known.items(), written, strict=True):
        spelled = [letters[phone] for phone in phones.split()]
        syllables = sum(bool(each["unstressed"]) for each in spelled)
        stressed = [STRESS in part for part in line.split("_") if ESPEAK_VOWELS.intersection(part)]
        if len(stressed) == syllables <= MOST_SYLLABLES and any(stressed):
            found.append(Word(text, phones, read_aloud(spelled, stressed)))
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


def phrases(
    words: Sequence[Word], rivals: Rivals, clips: int, rng: random.Random
) -> list[tuple[Phrase, ...]]:
    """Choose phrases, so many in all; each alone, or with one that sounds nearly the same."""
    by_phones = {word.phones: word for word in words}
    near = {
        word: [by_phones[said] for said in rivals[word.text] if said in by_phones] for word in words
    }
    paired = [word for word in words if near[word]]
    found: list[tuple[Phrase, ...]] = []
    count = 0
    while count < clips:
        phrase = rng.choices(words, k=rng.choice(LENGTHS))
        if rng.random() >= PAIRS:
            found.append((phrase,))
            count += 1
            continue
        place = rng.randrange(len(phrase))
        phrase[place] = rng.choice(paired)
        found.append((phrase, with_word(phrase, place, rng.choice(near[phrase[place]]))))
        count += 2
    return found


def otherwise(
    commands: Collection[Sequence[str]],
    words: Sequence[Word],
    rivals: Rivals,
    clips: int,
    rng: random.Random,
) -> list[tuple[Phrase]]:
    """Choose commands, so many in all, each with one word replaced by a short one.

    That sounds like no word of the list, nor is it one phone away from one: neither the commands
    nor their neighbors are taught.
    """
    known = {word.text: word for word in words}
    own = {word for command in commands for word in command}
    near = {said for word in own for said in rivals.get(word, ())}
    near |= {known[word].phones for word in own & known.keys()}
    others = [
        word
        for word in words
        if word.phones not in near and len(word.phones.split()) <= MOST_PHONES
    ]
    usable = [command for command in commands if len(command) > 1 and known.keys() >= {*command}]
    found = []
    for _ in range(clips):
        command = [known[word] for word in rng.choice(usable)]
        found.append((with_word(command, rng.randrange(len(command)), rng.choice(others)),))
    return found


def with_word(phrase: Phrase, place: int, word: Word) -> Phrase:
    """A phrase with another word at a place."""
    return [*phrase[:place], word, *phrase[place + 1 :]]


def voices_for(voices: Sequence[str], rng: random.Random) -> list[str]:
    """Choose a voice, or two to be mixed."""
    english = [voice for voice in voices if voice[0] in "ab"]
    if rng.random() < MIXED:
        return sorted({rng.choice(english), rng.choice(voices)})
    return [rng.choice(english if rng.random() < ENGLISH else voices)]


if __name__ == "__main__":
    typer.run(main)
