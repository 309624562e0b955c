"""Which symbols the phoneme network writes for each phone of the dictionary.

Run `python benchmarks/phones.py MANIFEST`: tab-separated, with the columns `path`, `phones` (those
of CMUdict as they were said, without times) and `speaker`. What the network is surest of is aligned
with the phones by edit distance; what a substitution costs is learned from the alignments, a few
times over. Prints each phone's symbols with their shares and numbers of speakers; those that
`ipa.tsv` does not have are marked `*`.
"""

from __future__ import annotations

import math
from collections import Counter, defaultdict
from collections.abc import Sequence
from itertools import groupby
from pathlib import Path
from typing import Annotated

import numpy as np
import soundfile
import typer

from voz.apps.recordings.manifest import parse_records
from voz.cli.text_io import with_bar
from voz.recognition.network.phoneme_network import BLANKS
from voz.recognition.network.score import load_network
from voz.recognition.network.symbols import PHONE_SYMBOLS_FILE

ROUNDS = 4
"""The alignments have settled by then."""

SKIPPED = 1.2
"""What it costs to leave a phone or a symbol out; one that is unknown costs 1.5 at first."""

LONGEST = 12.0
"""Seconds; longer recordings are left out."""

Pair = tuple[str, str]


def costs(counts: Counter[Pair]) -> dict[Pair, float]:
    """Learn what it costs to write a symbol for a phone: less, the more often it was."""
    totals: Counter[str] = Counter()
    for (phone, _), number in counts.items():
        totals[phone] += number
    return {
        (phone, symbol): -math.log((number + 0.05) / (totals[phone] + 3)) / 3
        for (phone, symbol), number in counts.items()
    }


def aligned(phones: Sequence[str], symbols: Sequence[str], known: dict[Pair, float]) -> list[Pair]:
    """Put together phones and the symbols that are written for them."""
    dearest = max(1.5, *known.values())
    best = np.zeros((len(phones) + 1, len(symbols) + 1))
    best[:, 0] = SKIPPED * np.arange(len(phones) + 1)
    best[0] = SKIPPED * np.arange(len(symbols) + 1)
    for i, phone in enumerate(phones, start=1):
        for j, symbol in enumerate(symbols, start=1):
            both = best[i - 1, j - 1] + known.get((phone, symbol), dearest)
            best[i, j] = min(both, best[i - 1, j] + SKIPPED, best[i, j - 1] + SKIPPED)
    pairs, i, j = [], len(phones), len(symbols)
    while i and j:
        if best[i, j] == best[i - 1, j] + SKIPPED:
            i -= 1
        elif best[i, j] == best[i, j - 1] + SKIPPED:
            j -= 1
        else:
            i, j = i - 1, j - 1
            pairs.append((phones[i], symbols[j]))
    return pairs


def read(manifest: Path) -> list[tuple[str, list[str], list[str]]]:
    """Read the speakers, phones and symbols of all recordings that have phones."""
    network = load_network()
    found = []
    rows = [row for row in parse_records(manifest.read_text()) if row["phones"]]
    for row in with_bar(rows, "reading"):
        samples, rate = soundfile.read(manifest.parent / row["path"], dtype="int16")
        if len(samples) < LONGEST * rate:
            best = network.log_probabilities(samples).argmax(axis=1)
            heard = (n for n, _ in groupby(best) if n < len(network.symbols) - BLANKS)
            symbols = [network.symbols[number] for number in heard]
            found.append((row["speaker"], row["phones"].split(), symbols))
    return found


def main(
    manifest: Annotated[Path, typer.Argument(help="Recordings with their phones.")],
    least: Annotated[float, typer.Option(help="Share of a symbol that is printed.")] = 0.02,
) -> None:
    """Print the symbols of each phone."""
    table = [
        line.split("\t") for line in PHONE_SYMBOLS_FILE.read_text(encoding="utf-8").splitlines()
    ]
    listed = {(phone, symbol) for phone, symbols in table for symbol in symbols.split()}
    known = dict.fromkeys(listed, 0.0)
    recordings = read(manifest)
    for _ in range(ROUNDS):
        speakers: dict[Pair, set[str]] = defaultdict(set)
        counts: Counter[Pair] = Counter()
        for speaker, phones, symbols in recordings:
            for pair in aligned(phones, symbols, known):
                counts[pair] += 1
                speakers[pair].add(speaker)
        known = costs(counts)
    print(f"{len(recordings)} recordings; share (speakers)")
    for phone, _ in table:
        of_it = {pair: n for pair, n in counts.most_common() if pair[0] == phone}
        total = sum(of_it.values())
        shown = (
            f"{pair[1]}{'' if pair in listed else '*'} {n / total:.3f} ({len(speakers[pair])})"
            for pair, n in of_it.items()
            if n >= least * total
        )
        print(f"{phone} {total}: {', '.join(shown)}")


if __name__ == "__main__":
    typer.run(main)
