"""How often commands are mixed up, by how alike they sound, where nothing is refused.

Run `python benchmarks/mixing.py audio_fixtures/manifest.tsv`. Each command is heard as it is and in
white noise, and every other command of the list is its rival.
"""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Iterator
from itertools import pairwise
from pathlib import Path
from typing import Annotated

import numpy as np
import typer
from machine import machine, one_line_errors

from voz.apps.recordings.manifest import read_manifest
from voz.audio import Samples
from voz.audio.sound_files import read_samples, to_int16
from voz.language.language_files import LanguageFiles
from voz.language.similarity import find_similar
from voz.language.similarity_report import confusion_rate
from voz.recognition.language import Language, load_language, spellings
from voz.recognition.network.score import scorer_for

NOISES = (None, 10, 5, 0)
"""Signal to noise, dB."""

BINS = (0.5, 0.6, 0.65, 0.7, 0.75, 0.8, 1.01)


def likeness(language: Language) -> dict[frozenset[str], float]:
    """How alike each two commands sound."""
    ways = spellings(language.dictionary)
    phones = {word: [" ".join(way) for way in each] for word, each in ways.items()}
    pairs = find_similar(language.commands.listed, phones, at_least=0.0)
    return {frozenset((pair.first, pair.second)): pair.similarity for pair in pairs}


def noisy(samples: Samples, snr: int | None, chance: np.random.Generator) -> Samples:
    """A clip in white noise, by its whole length."""
    sound = samples.astype(np.float64) / 32768
    if snr is None:
        return samples
    level = np.sqrt(np.mean(sound**2) / 10 ** (snr / 10))
    return to_int16(sound + chance.normal(0, level, len(sound)))


def heard(manifest: Path, language: Language) -> Iterator[tuple[int | None, str, str]]:
    """Each command with what it was taken for."""
    network = scorer_for(language)
    chance = np.random.default_rng(0)
    for clip in read_manifest(manifest):
        if clip.text in language.commands:
            samples = read_samples(clip.path)
            for snr in NOISES:
                said = noisy(samples, snr, chance)
                ranking = network.rank(network.phone_likelihoods(said), language.commands.listed)
                yield snr, clip.text, ranking.text


def main(
    manifest: Annotated[Path, typer.Argument(help="Its commands are heard.")],
    lm: Annotated[Path, typer.Option(help="Language files.")] = Path("lm"),
) -> None:
    """Print how often commands are taken for others, by how alike they sound and the noise."""
    language = load_language(LanguageFiles(lm))
    alike = likeness(language)
    taken: dict[tuple[int | None, int], list[bool]] = defaultdict(list)
    for snr, said, found in heard(manifest, language):
        for other in language.commands:
            if other != said:
                place = int(np.digitize(alike[frozenset((said, other))], BINS))
                taken[snr, place].append(found == other)
    print(f"{machine()}\n")
    names = ["quiet" if snr is None else f"{snr} dB" for snr in NOISES]
    print(f"| alike | pairs | {' | '.join(names)} | estimate |\n|{' --- |' * (len(names) + 3)}")
    for place, (low, high) in enumerate(pairwise(BINS), start=1):
        shares = [taken[snr, place] for snr in NOISES]
        if shares[0]:
            shown = " | ".join(f"{np.mean(share):.3f}" for share in shares)
            middle = confusion_rate((low + min(high, 1)) / 2)
            print(f"| {low} to {high} | {len(shares[0])} | {shown} | {middle:.3f} |")


if __name__ == "__main__":
    with one_line_errors():
        typer.run(main)
