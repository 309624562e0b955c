"""How long README takes to read, and how hard the sentences of the documents are.

Run `python benchmarks/reading.py`; `--seed 2` draws other sentences. The measure is the
Flesch-Kincaid grade of a sentence (Kincaid et al. 1975): 0.39 words a sentence + 11.8 syllables a
word - 15.59, years of school in the United States. What is between backticks is what somebody
types: one word of one syllable. Syllables are the vowels in the pronunciations of pocketsphinx's
dictionary, or groups of vowels in words that it lacks.
"""

from __future__ import annotations

import random
import re
import sys
from collections.abc import Iterator
from functools import cache
from pathlib import Path
from typing import Annotated

import typer
from pocketsphinx import get_model_path

sys.path.insert(0, str(Path(__file__).parent.parent / "tools"))

from first_hour import BLOCK, LINK, ROOT, WORDS_A_MINUTE, minutes  # a script beside the others

FEWEST_WORDS = 5
"""A sentence has at least so many: others are headings or cells."""

CODE = re.compile(r"`[^`]*`")
BESIDE_TEXT = re.compile(r"<[^>]*>|^[ #>]+|^ *(- |\d+\. )|\*\*", re.MULTILINE)
END = re.compile(r"(?<=[a-z0-9)\"`*])[.?!](?=\s|$)")


@cache
def dictionary() -> dict[str, int]:
    """The syllables of each word of pocketsphinx's dictionary: the vowels in its pronunciation."""
    path = Path(get_model_path("en-us")) / "cmudict-en-us.dict"
    lines = (line.split() for line in path.read_text(encoding="utf-8").splitlines())
    return {word: sum(phone[0] in "AEIOU" for phone in phones) for word, *phones in lines}


def syllables(word: str) -> int:
    """Count the syllables of a word."""
    return dictionary().get(word) or max(1, len(re.findall(r"[aeiouy]+", word)))


def grade(sentence: str) -> float:
    """The Flesch-Kincaid grade of a sentence: years of school in the United States."""
    words = [word.lower() for word in re.findall(r"[A-Za-z']+", CODE.sub("x", sentence))]
    return 0.39 * len(words) + 11.8 * sum(map(syllables, words)) / len(words) - 15.59


def sentences(text: str) -> Iterator[str]:
    """Yield the sentences of a page: those of its paragraphs and lists, not of its tables."""
    text = LINK.sub(r"\1", BLOCK.sub("", text))
    for paragraph in re.split(r"\n\s*\n|\n(?= *(?:- |\d+\. ))", text):
        lines = [line for line in paragraph.splitlines() if not line.startswith(("|", "#"))]
        plain = " ".join(BESIDE_TEXT.sub("", "\n".join(lines)).split())
        for sentence in END.split(plain):
            if len(re.findall(r"[A-Za-z']+", sentence)) >= FEWEST_WORDS:
                yield sentence.strip()


def main(
    seed: Annotated[int, typer.Option(help="Which sentences are drawn.")] = 1,
    count: Annotated[int, typer.Option(min=1, help="How many.")] = 20,
    worst: Annotated[int, typer.Option(min=1, help="How many of the hardest are shown.")] = 20,
) -> None:
    """Print the minutes of README, the grade of sentences drawn at random, and the hardest ones."""
    readme = (ROOT / "README.md").read_text(encoding="utf-8")
    reading = minutes(readme)
    words = round(reading * WORDS_A_MINUTE)
    print(f"README: {words} words without blocks, {reading:.1f} minutes")
    pages = sorted((ROOT / "docs").glob("*.md"))
    found = [(grade(s), p.name, s) for p in pages for s in sentences(p.read_text("utf-8"))]
    grades = sorted(each for each, *_ in found)
    middle, high = (grades[round(share * (len(grades) - 1))] for share in (0.5, 0.9))
    print(f"docs: {len(found)} sentences, grade {middle:.1f}, one in ten above {high:.1f}")
    for title, some in (
        (f"{count} drawn by seed {seed}", random.Random(seed).sample(found, count)),
        (f"the {worst} hardest", sorted(found, reverse=True)[:worst]),
    ):
        print(f"\n{title}: grade {sum(each for each, *_ in some) / len(some):.1f}")
        for each, name, sentence in some:
            print(f"{each:5.1f}  {name}: {sentence}")


if __name__ == "__main__":
    typer.run(main)
