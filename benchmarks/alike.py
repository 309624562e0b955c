"""Whether commands that `voz build-lm` warns of are mixed up more than others.

Run `python benchmarks/alike.py MANIFEST...`: what is said in at least `--least` recordings becomes
one list; each recording is decoded in white noise. Prints how many recordings of the two commands
of a pair are taken for the other one, or are not taken as it may be either, by how alike they
sound, and what `confusion_rate` says. Half of the speakers fit its scale at `FITTED_SNR`, and the
other half is to prove it.
"""

from __future__ import annotations

import re
from collections import Counter, defaultdict
from collections.abc import Callable, Sequence
from itertools import pairwise
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Annotated, TypeAlias

import numpy as np
import typer
from machine import machine, one_line_errors
from mixing import noisy

from voz.api.recognizer import Recognizer
from voz.apps.recordings.manifest import Clip, read_manifest
from voz.audio import Samples
from voz.audio.sound_files import read_samples
from voz.cli.text_io import with_bar
from voz.language.build import build
from voz.language.command_source import read_list
from voz.language.language_files import LanguageFiles
from voz.language.similarity import SimilarPair, find_similar
from voz.language.similarity_report import WARNING_SIMILARITY, confusion_rate
from voz.settings import Recognition

BOUNDS = (1.01, WARNING_SIMILARITY, 0.82, 0.77, 0.72, 0.65)
"""Of the classes of similarity; from the second up there is a warning."""


NOISES = (5, 0)
"""Signal to noise, dB; with less noise hardly anything is mixed up."""

FITTED_SNR = 0

SPOKEN = re.compile(r"[a-z']+( [a-z']+)*")


def chosen(clips: Sequence[Clip], least: int, most: int) -> list[Clip]:
    """Return at most so many recordings of each text that has enough, of as many speakers."""
    by_text: dict[str, list[Clip]] = defaultdict(list)
    for clip in clips:
        if SPOKEN.fullmatch(clip.text or ""):
            by_text[clip.text].append(clip)
    found = []
    for said in by_text.values():
        if len(said) >= least:
            seen: Counter[str] = Counter()
            turns = [(seen.update([c.speaker]) or seen[c.speaker], n) for n, c in enumerate(said)]
            found += [said[n] for _, n in sorted(turns)[:most]]
    return found


RIGHT, MIXED, DOUBTED, REFUSED = "right", "mixed up", "unsure", "refused"

Outcome: TypeAlias = tuple[str, frozenset[str]]
"""What became of a recording, and the pair of what was said and what was heard instead."""


def outcome(recognizer: Recognizer, text: str, samples: Samples) -> Outcome:
    """Decode a recording of a text."""
    found = list(recognizer.utterances([samples], "clip"))
    said = max(found, key=lambda each: each.end - each.start, default=None)
    if said is None or (not said.accepted and not said.between):
        return REFUSED, frozenset()
    if said.between:
        return DOUBTED, frozenset(said.between)
    return (RIGHT if said.text == text else MIXED), frozenset((text, said.text))


def row(pairs: Sequence[SimilarPair], said: Counter[str], found: Counter[Outcome]) -> str:
    """Count recordings of all pairs, those taken for the other one, and those in doubt of both."""
    recordings = sum(said[p.first] + said[p.second] for p in pairs)
    both = [frozenset((p.first, p.second)) for p in pairs]
    wrong, doubted = (sum(found[what, pair] for pair in both) for what in (MIXED, DOUBTED))
    share = 100 * (wrong + doubted) / recordings if recordings else 0.0
    return f"{recordings} | {wrong} | {doubted} | {share:.2f}"


def main(
    manifests: list[Path],
    least: Annotated[int, typer.Option(help="Recordings that a text needs.")] = 6,
    most: Annotated[int, typer.Option(help="Recordings of a text that are decoded.")] = 12,
) -> None:
    """Decode, and print the tables."""
    clips = chosen([c for path in manifests for c in read_manifest(path)], least, most)
    texts = list(dict.fromkeys(clip.text for clip in clips))
    halves = ("fit", "proof")
    half = {name: halves[n % 2] for n, name in enumerate(sorted({c.speaker for c in clips}))}
    said = {each: Counter(c.text for c in clips if half[c.speaker] == each) for each in halves}
    found = {(each, snr): Counter[Outcome]() for each in halves for snr in NOISES}
    chance = np.random.default_rng(0)
    with TemporaryDirectory() as name:
        folder = Path(name)
        (folder / "list.txt").write_text("\n".join(texts) + "\n")
        source = read_list(folder / "list.txt")
        build(folder / "list.txt", folder, source)
        recognizer = Recognizer(LanguageFiles(folder), Recognition())
        for clip in with_bar(clips, "decoding"):
            samples = read_samples(clip.path)
            for snr in NOISES:
                came = outcome(recognizer, clip.text, noisy(samples, snr, chance))
                found[half[clip.speaker], snr][came] += 1
    phones = {word: entry.phones for word, entry in source.entries.items()}
    pairs = find_similar(texts, phones, at_least=BOUNDS[-1])
    print(f"{machine()}\n{len(texts)} commands, {len(clips)} recordings\n")
    for (each, snr), counted in found.items():
        outcomes = Counter[str]()
        for (what, _), number in counted.items():
            outcomes[what] += number
        told = ", ".join(f"{what} {outcomes[what]}" for what in (RIGHT, MIXED, DOUBTED, REFUSED))
        print(f"\n{each}, {snr} dB: {told}\n")
        print("| alike | pairs | recordings | mixed up | unsure | in 100 | told, in 100 |")
        print("|---|---|---|---|---|---|---|")
        for upper, lower in pairwise(BOUNDS):
            here = [p for p in pairs if lower <= p.similarity < upper]
            rate = 100 * mean_rate(here, said[each], confusion_rate)
            print(f"| {lower:.2f} | {len(here)} | {row(here, said[each], counted)} | {rate:.1f} |")
    scale = fitted_scale(pairs, said["fit"], found["fit", FITTED_SNR])
    print(f"\nscale by the first half of the speakers at {FITTED_SNR} dB: {scale:.1f}")


Rate: TypeAlias = Callable[[float], float]
"""Gives how often a command is mixed up with one that sounds so much alike."""


def mean_rate(pairs: Sequence[SimilarPair], said: Counter[str], rate: Rate) -> float:
    """Return the mean rate of all recordings of pairs."""
    recordings = [said[p.first] + said[p.second] for p in pairs]
    if not sum(recordings):
        return 0.0
    return float(np.average([rate(p.similarity) for p in pairs], weights=recordings))


def fitted_scale(
    pairs: Sequence[SimilarPair], said: Counter[str], found: Counter[Outcome]
) -> float:
    """Return the scale by which what was mixed up, or in doubt, is likeliest."""
    recordings = np.array([said[p.first] + said[p.second] for p in pairs])
    both = [frozenset((p.first, p.second)) for p in pairs]
    wrong = np.array([found[MIXED, pair] + found[DOUBTED, pair] for pair in both])
    apart = np.sqrt(1 - np.array([p.similarity for p in pairs]))

    def likelihood(scale: float) -> float:
        rate = 0.5 * np.exp(-scale * apart)
        return float(np.sum(wrong * np.log(rate) - recordings * rate))

    return float(max(np.arange(5, 20, 0.1), key=likelihood))


if __name__ == "__main__":
    with one_line_errors():
        typer.run(main)
