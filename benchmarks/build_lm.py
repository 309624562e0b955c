"""Time and memory to build the language files, to load them, and to parse a sentence.

Lists are flat, or templates that say as many sentences, or millions. Run
`python benchmarks/build_lm.py`; each line of the table is measured in processes of their own.
"""

from __future__ import annotations

import subprocess
import sys
import tempfile
import time
from collections.abc import Iterator
from itertools import product
from pathlib import Path

from lists import listed
from machine import machine, peak_megabytes
from pocketsphinx import Config, Decoder, get_model_path

from voz.language.build import build
from voz.language.language_files import LanguageFiles, read_commands
from voz.language.pronunciation import read_cmudict
from voz.language.sentences.text_lines import MAX_TEXT_BYTES

SMALL = Path(__file__).parent.parent / "lm" / "comandos_voz.txt"
LARGE_SENTENCES = 50_000
SIZES = (100, 1_000, 10_000)
PARSED = 200

VERBS = "bring carry clean close drop fetch find hide lift lock"
COLOURS = "black blue broken brown clean cold empty gray green heavy"
THINGS = "apple bag ball book bottle bowl box chair cup door"
PLACES = "garden hall kitchen lab office room shed shop store yard"
WORDS = {
    **{"verb": VERBS, "colour": COLOURS, "thing": THINGS, "place": PLACES},
    **{"other": COLOURS, "more": THINGS, **dict.fromkeys("abcde", THINGS)},
}
"""What the lists of the templates say."""

TEMPLATES = {
    100: "{verb} the {thing}",
    1_000: "{verb} the {colour} {thing}",
    10_000: "{verb} the {colour} {thing} in the {place}",
    3_025_000: "[please] {verb} [the] [{colour}] {thing} [and the [{other}] {more}] in the {place}",
    1_000_000_000: "{verb} {colour} {thing} {place} {a} {b} {c} {d} {e}",
}
"""By about how many sentences they say."""


ACTIONS = ("build", "load grammar", "load in voz", "load trigram", f"parse {PARSED}")


def large_list() -> str:
    """Make 50,000 sentences of two and three words from 1,200 dictionary words, below 1 MB."""
    heads = {line.split(" ")[0] for line in read_cmudict().decode().splitlines()}
    words = sorted(word for word in heads if word.isalpha() and 4 <= len(word) <= 5)
    words = words[:: len(words) // 1200]
    pairs = [" ".join(pair) for pair in product(words[::20], words)][: LARGE_SENTENCES // 2]
    short = [word for word in words if len(word) == 4]
    triples = (" ".join(three) for three in product(short[::25], short[::12], short))
    sentences = [*pairs, *triples][:LARGE_SENTENCES]
    text = "".join(f"{sentence}\n" for sentence in sentences)
    assert len(sentences) == LARGE_SENTENCES
    assert len(text) <= MAX_TEXT_BYTES
    return text


def some(folder: Path) -> Iterator[tuple[str, Path]]:
    """Write lists and templates of several sizes."""
    lists = "".join(f"{name} = {' | '.join(text.split())}\n" for name, text in WORDS.items())
    for size in SIZES:
        path = folder / f"{size}.txt"
        path.write_text("\n".join(listed(["stop"], size)))
        yield f"{size:,}", path
    for size, template in TEMPLATES.items():
        path = folder / f"templates{size}.txt"
        path.write_text(f"do: {template}\nstop\n{lists}")
        yield f"{size:,} by templates", path


def do(action: str, commands: Path, out: Path) -> None:
    files = LanguageFiles(out)
    model = {"hmm": get_model_path("en-us/en-us"), "dict": str(files.dictionary)}
    quiet = {"loglevel": "FATAL"}
    start = time.perf_counter()
    if action == "build":
        build(commands, out)
    elif action == "load in voz":
        from voz.recognition.language import load_language
        from voz.recognition.pocketsphinx.decoder import Decoder as Searched

        Searched(load_language(files))
    elif action.startswith("parse"):
        commands_known = read_commands(files)
        drawn = commands_known.sample(PARSED)
        start = time.perf_counter()
        for sentence in drawn:
            assert commands_known.parse(sentence)
    elif action == "load grammar":
        Decoder(Config(**model, **quiet, lm=None, jsgf=str(files.grammar), bestpath=False))
    else:
        Decoder(Config(**model, **quiet, lm=str(files.lm)))
    seconds = time.perf_counter() - start
    print(f"{seconds:.3f} s | {peak_megabytes():.0f} MB", end="")


def measure(action: str, commands: Path, out: Path) -> str:
    """Do one thing in a process of its own, so that its peak memory is its own."""
    command = [sys.executable, __file__, action, str(commands), str(out)]
    start = time.perf_counter()
    printed = subprocess.run(command, check=True, capture_output=True, text=True).stdout
    return f"{printed} | {time.perf_counter() - start:.2f} s"


def main() -> None:
    print(f"{machine()}\n")
    print("| sentences | action | time | peak memory | with start and imports |")
    print("|---|---|---|---|---|")
    with tempfile.TemporaryDirectory() as folder:
        large = Path(folder) / "large.txt"
        large.write_text(large_list())
        for name, commands in (("14", SMALL), *some(Path(folder)), (f"{LARGE_SENTENCES:,}", large)):
            out = Path(folder) / name
            for action in ACTIONS:
                print(f"| {name} | {action} | {measure(action, commands, out)} |", flush=True)


if __name__ == "__main__":
    if len(sys.argv) == 1:
        main()
    else:
        do(sys.argv[1], Path(sys.argv[2]), Path(sys.argv[3]))
