"""Time and memory to build the language files, and to load them in pocketsphinx.

Run `python benchmarks/build_lm.py`; each line of the table is measured in processes of their own.
"""

from __future__ import annotations

import subprocess
import sys
import tempfile
import time
from itertools import product
from pathlib import Path

from machine import machine, peak_megabytes
from pocketsphinx import Config, Decoder, get_model_path

from voz.language.build import build
from voz.language.commands import MAX_BYTES
from voz.language.files import LanguageFiles
from voz.language.lexicon import read_cmudict

SMALL = Path(__file__).parent.parent / "lm" / "comandos_voz.txt"
LARGE_SENTENCES = 50_000


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
    assert len(text) <= MAX_BYTES
    return text


def do(action: str, commands: Path, out: Path) -> None:
    files = LanguageFiles(out)
    model = {"hmm": get_model_path("en-us/en-us"), "dict": str(files.dictionary)}
    quiet = {"loglevel": "FATAL"}
    start = time.perf_counter()
    if action == "build":
        build(commands, out)
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
        for name, commands in (("14", SMALL), (f"{LARGE_SENTENCES:,}", large)):
            out = Path(folder) / name
            for action in ("build", "load grammar", "load trigram"):
                print(f"| {name} | {action} | {measure(action, commands, out)} |", flush=True)


if __name__ == "__main__":
    if len(sys.argv) == 1:
        main()
    else:
        do(sys.argv[1], Path(sys.argv[2]), Path(sys.argv[3]))
