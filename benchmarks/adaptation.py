"""What learning the microphone and the speaker gains, and what it costs those who need none.

Run `python benchmarks/adaptation.py MANIFEST...` with lists of recordings as `voz eval` reads them.
Counted are the commands that are right, those that are right and accepted, and those in which
something wrong is accepted.

- digits: near-misses of the condition `human` with a grammar of the ten digits; each speaker's
  first 14, in several orders, are learnt from as they are understood; the rest is scored.
- each speaker alone: the commands, scored while it learns.
- one microphone: the commands of all speakers of a condition mixed, scored while it learns.
- after talk and noise: each speaker alone, after all of the talk and noise was heard.
- calibrated: each speaker by what `voz calibrate` makes of the other sentences.
"""

from __future__ import annotations

import random
import sys
import tempfile
from collections import defaultdict
from collections.abc import Iterable, Sequence
from functools import cache
from pathlib import Path

import numpy as np

from voz.audio import SAMPLE_RATE, Samples
from voz.audio.files import read_blocks
from voz.config import Recognition
from voz.evaluation.manifest import read_manifests
from voz.evaluation.results import Clip
from voz.language.build import build
from voz.language.files import LanguageFiles, find_language
from voz.recognition.adaptation import StartVector
from voz.recognition.calibration import FEWEST, Said, Score, calibrate, score
from voz.recognition.recognizer import Recognizer

DIGITS = ("zero", "one", "two", "three", "four", "five", "six", "seven", "eight", "nine")
LEARNT_FROM = 14
SEEDS = range(3)
PARTS = 7
COLUMNS = (lambda s: s.right, lambda s: s.obeyed, lambda s: s.wrong)


class Ears:
    """A recogniser that learns, and one that hears the same and does not."""

    def __init__(self, language: LanguageFiles) -> None:
        self.learning = Recognizer(language, Recognition(), learning=True)
        self._still = Recognizer(language, Recognition())

    def learn(self, clips: Iterable[Clip], learnt: StartVector | None = None) -> list[Score]:
        """Start from what was learnt before, and score while learning."""
        self.learning.learnt = learnt or StartVector()
        return [score([said(clip)], self.learning) for clip in clips]

    def hear(self, clips: Iterable[Clip], learnt: StartVector | None = None) -> list[Score]:
        """Score without learning."""
        self._still.learnt = learnt or StartVector()
        return [score([said(clip)], self._still) for clip in clips]


@cache
def samples(path: Path) -> Samples:
    return np.concatenate(list(read_blocks(path)))


def said(clip: Clip) -> Said:
    return Said(clip.text, samples(clip.path))


def by(clips: Iterable[Clip], column: str) -> dict[str, list[Clip]]:
    groups: dict[str, list[Clip]] = defaultdict(list)
    for clip in clips:
        groups[getattr(clip, column)].append(clip)
    return groups


def shuffled(clips: Sequence[Clip], seed: int) -> list[Clip]:
    return random.Random(seed).sample(clips, len(clips))


def row(name: str, before: list[Score], after: list[Score]) -> None:
    def shares(scores: list[Score]) -> list[float]:
        return [float(np.mean([column(s) for s in scores])) for column in COLUMNS]

    pairs = zip(shares(before), shares(after), strict=True)
    cells = " | ".join(f"{old:.3f} → {new:.3f}" for old, new in pairs)
    print(f"| {name} | {len(before)} | {cells} |", flush=True)


def digits(clips: list[Clip], ears: Ears) -> None:
    totals: tuple[list[Score], list[Score]] = [], []
    for speaker, own in by(clips, "speaker").items():
        before: list[Score] = []
        after: list[Score] = []
        for seed in SEEDS:
            order = shuffled(own, seed)
            before += ears.hear(order[LEARNT_FROM:])
            ears.learn(order[:LEARNT_FROM])
            after += ears.hear(order[LEARNT_FROM:], ears.learning.learnt)
        row(f"digits, {speaker}", before, after)
        totals[0].extend(before)
        totals[1].extend(after)
    if clips:
        row("digits, all", *totals)


def commands(clips: list[Clip], ears: Ears, later: StartVector) -> None:
    for condition, spoken in by(clips, "condition").items():
        order = shuffled(spoken, 0)
        speakers = by(order, "speaker").values()
        before = [s for own in speakers for s in ears.hear(own)]
        row(
            f"{condition}, each speaker alone",
            before,
            [s for own in speakers for s in ears.learn(own)],
        )
        row(f"{condition}, one microphone", before, ears.learn(order))
        row(
            f"{condition}, after talk and noise",
            before,
            [s for own in speakers for s in ears.learn(own, later)],
        )


def calibrated(clips: list[Clip], ears: Ears, language: LanguageFiles) -> None:
    for condition, spoken in by(clips, "condition").items():
        before: list[Score] = []
        after: list[Score] = []
        for own in by(spoken, "speaker").values():
            texts = sorted({clip.text for clip in own})
            if len(texts) <= FEWEST:
                continue
            for part in range(PARTS):
                judged = [c for c in own if texts.index(c.text) % PARTS == part]
                others = [said(clip) for clip in own if clip not in judged]
                before += ears.hear(judged)
                with tempfile.TemporaryDirectory() as folder:
                    found = calibrate(others, language, Recognition(), Path(folder))
                    recognizer = Recognizer(language, Recognition(), found.profile)
                    after += [score([said(clip)], recognizer) for clip in judged]
        if before:
            row(f"{condition}, calibrated", before, after)


def talk_and_noise(clips: list[Clip], ears: Ears) -> StartVector:
    """Let it hear what is no command; returns what it learnt from that."""
    obeyed = sum(s.wrong for s in ears.learn(shuffled(clips, 0)))
    minutes = sum(len(samples(clip.path)) for clip in clips) / SAMPLE_RATE / 60
    learnt = ears.learning.learnt
    print(f"\n{minutes:.0f} minutes of talk and noise, {obeyed} false alarms, taught {learnt}\n")
    return learnt


def digit_language(folder: Path) -> LanguageFiles:
    files = LanguageFiles(folder)
    files.commands.write_text("".join(f"{digit}\n" for digit in DIGITS), encoding="utf-8")
    build(files.commands, folder)
    return files


def main(manifests: list[str]) -> None:
    clips = read_manifests(map(Path, manifests))
    print("| | utterances | right | right and accepted | wrong and accepted |")
    print("|---|---|---|---|---|")
    with tempfile.TemporaryDirectory() as folder:
        ears = Ears(digit_language(Path(folder)))
    digits([c for c in clips if c.condition == "human" and c.text in DIGITS], ears)
    language = find_language(None)
    ears = Ears(language)
    spoken = [c for c in clips if c.kind == "command"]
    calibrated(spoken, ears, language)
    commands(spoken, ears, talk_and_noise([c for c in clips if c.kind in ("talk", "noise")], ears))


if __name__ == "__main__":
    main(sys.argv[1:])
