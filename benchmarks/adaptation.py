"""What `voz calibrate` wins, each speaker judged on recordings that the profile was not made from.

Run `python benchmarks/adaptation.py MANIFEST... [--list FILE]`; manifests are those of `voz eval`.
The recordings of each speaker whose text is in the list are divided into parts; each part is scored
with profiles of at most 24 of the others, as many as `voz calibrate` asks for.

Printed for the recognition without a profile, with each part of a profile, and with what `voz
calibrate` chooses: the share right and accepted, its change with a 95 % interval (bootstrap over
the speakers), and the share in which something wrong is accepted.
"""

from __future__ import annotations

import math
import random
import shutil
import tempfile
from collections import defaultdict
from collections.abc import Iterable, Sequence
from pathlib import Path
from typing import Annotated

import numpy as np
import typer

from voz.apps.evaluation.noise import embed_in_noise
from voz.apps.recordings.calibration import MIN_SENTENCES, Said, Score, calibrate, fit, score
from voz.apps.recordings.enrollment import PROMPT_COUNT
from voz.apps.recordings.manifest import Clip, read_manifests
from voz.audio.sound_files import read_blocks
from voz.language.build import build
from voz.language.language_files import LanguageFiles, find_language, read_sentences
from voz.recognition.engine import RecognitionEngine
from voz.recognition.language import load_language
from voz.recognition.speaker.adaptation import Aligner
from voz.recognition.speaker.profiles import Profile
from voz.settings import Recognition

RESAMPLINGS = 2000

Scores = dict[str, dict[str, list[Score]]]
"""Of each way, by speaker."""


def measure(
    speakers: dict[str, list[Said]], language: LanguageFiles, settings: Recognition, parts: int
) -> Scores:
    """Score each speaker in each way."""
    aligner = Aligner(load_language(language))
    scores: Scores = defaultdict(lambda: defaultdict(list))
    for number, (speaker, said) in enumerate(speakers.items(), start=1):
        order = random.Random(0).sample(said, len(said))
        for part in range(parts):
            judged = order[part::parts]
            others = [each for each in order if all(each is not one for one in judged)]
            with tempfile.TemporaryDirectory() as name:
                profiles = ways(others[:PROMPT_COUNT], language, settings, aligner, Path(name))
                for way, profile in profiles.items():
                    recognizer = RecognitionEngine(language, settings, profile)
                    scores[way][speaker] += [score([each], recognizer) for each in judged]
        print(f"{number} of {len(speakers)}", end="\r", flush=True)
    return scores


def ways(
    said: Sequence[Said],
    language: LanguageFiles,
    settings: Recognition,
    aligner: Aligner,
    folder: Path,
) -> dict[str, Profile]:
    """The profiles that are compared."""
    fitted = fit(said, aligner, folder / "mllr.txt")
    return {
        "no profile": Profile(),
        "the start of the cepstral mean": Profile(fitted.start),
        "the start and MLLR": fitted,
        "twice the odds": Profile(log_odds=math.log(2)),
        "`voz calibrate`": calibrate(said, language, settings, folder).profile,
    }


def table(scores: Scores) -> Iterable[str]:
    """The rows of a table, a way each."""
    yield "| | right | right and accepted | change | wrong and accepted |"
    yield "|---|---|---|---|---|"
    before = scores["no profile"]
    for way, of_speakers in scores.items():
        every = [each for own in of_speakers.values() for each in own]
        right, accepted, wrong = (
            f"{np.mean([getattr(each, name) for each in every]):.3f}"
            for name in ("right", "accepted", "wrong")
        )
        yield f"| {way} | {right} | {accepted} | {change(before, of_speakers)} | {wrong} |"


def change(before: dict[str, list[Score]], after: dict[str, list[Score]]) -> str:
    """By how much more is right and accepted, with its interval."""
    names = list(before)
    gained = np.array(
        [sum(s.accepted for s in after[n]) - sum(s.accepted for s in before[n]) for n in names]
    )
    count = np.array([len(before[name]) for name in names])
    drawn = np.random.default_rng(0).integers(len(names), size=(RESAMPLINGS, len(names)))
    low, high = np.percentile(gained[drawn].sum(1) / count[drawn].sum(1), (2.5, 97.5))
    return f"{gained.sum() / count.sum():+.3f} ({low:+.3f} to {high:+.3f})"


def by_speaker(clips: Iterable[Clip], noise: Path | None, snr: float) -> dict[str, list[Said]]:
    """The recordings of each speaker who says enough different sentences."""
    rng = np.random.default_rng(0)
    background = None if noise is None else np.concatenate(list(read_blocks(noise)))
    found: dict[str, list[Said]] = defaultdict(list)
    for clip in clips:
        samples = np.concatenate(list(read_blocks(clip.path)))
        if background is not None:
            samples = embed_in_noise(background, samples, snr, rng)
        found[clip.speaker].append(Said(clip.text, samples))
    return {
        name: said
        for name, said in found.items()
        if len({each.text for each in said}) >= MIN_SENTENCES
    }


def main(
    manifests: list[Path],
    listed: Annotated[
        Path | None, typer.Option("--list", help="What is said; else the usual commands.")
    ] = None,
    condition: Annotated[str | None, typer.Option(help="Only recordings of this one.")] = None,
    parts: Annotated[int, typer.Option(help="Of the recordings of each speaker.")] = 7,
    most: Annotated[int | None, typer.Option(help="Only so many speakers.")] = None,
    noise: Annotated[Path | None, typer.Option(help="Mixed into all recordings.")] = None,
    snr: Annotated[float, typer.Option(help="How much louder the speech is, dB.")] = 10.0,
    network: Annotated[bool, typer.Option(help="Whether the network decides.")] = True,
) -> None:
    """Print the table."""
    with tempfile.TemporaryDirectory() as folder:
        language = LanguageFiles(Path(folder)) if listed else find_language(None)
        if listed:
            shutil.copy(listed, language.commands)
            build(language.commands, language.folder)
        texts = set(read_sentences(language))
        clips = [
            clip
            for clip in read_manifests(manifests)
            if clip.text in texts and condition in (None, clip.condition)
        ]
        speakers = dict(list(by_speaker(clips, noise, snr).items())[:most])
        print(f"{len(speakers)} speakers, {sum(map(len, speakers.values()))} recordings")
        scores = measure(speakers, language, Recognition(use_network=network), parts)
        print(*table(scores), sep="\n")


if __name__ == "__main__":
    typer.run(main)
