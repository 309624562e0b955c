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

from voz.api.recognizer import Recognizer
from voz.apps.recordings.calibration import MIN_SENTENCES, Said, Score, calibrate, score
from voz.apps.recordings.manifest import Clip, read_manifests
from voz.audio import SAMPLE_RATE, Samples
from voz.audio.sound_files import read_blocks
from voz.language.build import build
from voz.language.language_files import LanguageFiles, find_language
from voz.recognition.engine import learned_by
from voz.recognition.speaker.adaptation import StartVector
from voz.recognition.speaker.profiles import Profile
from voz.settings import Recognition

DIGITS = ("zero", "one", "two", "three", "four", "five", "six", "seven", "eight", "nine")
LEARNT_FROM = 14
SEEDS = range(3)
PARTS = 7
NOTHING = StartVector()
COLUMNS = ("right", "accepted", "wrong")


def hear(language: LanguageFiles, clips: Iterable[Clip], learnt: StartVector) -> list[Score]:
    """Score with what was learnt before."""
    recognizer = Recognizer(language, Recognition(), Profile(learnt))
    return [score([said(clip)], recognizer) for clip in clips]


def learn(
    language: LanguageFiles, clips: Iterable[Clip], learnt: StartVector
) -> tuple[list[Score], StartVector]:
    """Score while learning more; gives what is known then, too."""
    recognizer = Recognizer(language, Recognition(), Profile(learnt), learning=True)
    return [score([said(clip)], recognizer) for clip in clips], learned_by(recognizer)


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
        return [float(np.mean([getattr(s, column) for s in scores])) for column in COLUMNS]

    pairs = zip(shares(before), shares(after), strict=True)
    cells = " | ".join(f"{old:.3f} → {new:.3f}" for old, new in pairs)
    print(f"| {name} | {len(before)} | {cells} |", flush=True)


def digits(clips: list[Clip], language: LanguageFiles) -> None:
    totals: tuple[list[Score], list[Score]] = [], []
    for speaker, own in by(clips, "speaker").items():
        before: list[Score] = []
        after: list[Score] = []
        for seed in SEEDS:
            order = shuffled(own, seed)
            _, learnt = learn(language, order[:LEARNT_FROM], NOTHING)
            before += hear(language, order[LEARNT_FROM:], NOTHING)
            after += hear(language, order[LEARNT_FROM:], learnt)
        row(f"digits, {speaker}", before, after)
        totals[0].extend(before)
        totals[1].extend(after)
    if clips:
        row("digits, all", *totals)


def commands(clips: list[Clip], language: LanguageFiles, later: StartVector) -> None:
    for condition, spoken in by(clips, "condition").items():
        order = shuffled(spoken, 0)
        speakers = by(order, "speaker").values()
        ordered = [clip for own in speakers for clip in own]
        before = hear(language, ordered, NOTHING)
        for name, groups, learnt in (
            ("each speaker alone", speakers, NOTHING),
            ("one microphone", [order], NOTHING),
            ("after talk and noise", speakers, later),
        ):
            after = [s for own in groups for s in learn(language, own, learnt)[0]]
            row(f"{condition}, {name}", before, after)


def calibrated(clips: list[Clip], language: LanguageFiles) -> None:
    for condition, spoken in by(clips, "condition").items():
        before: list[Score] = []
        after: list[Score] = []
        for own in by(spoken, "speaker").values():
            texts = sorted({clip.text for clip in own})
            if len(texts) <= MIN_SENTENCES:
                continue
            before += hear(language, own, NOTHING)
            for part in range(PARTS):
                judged = [c for c in own if texts.index(c.text) % PARTS == part]
                others = [said(clip) for clip in own if clip not in judged]
                with tempfile.TemporaryDirectory() as folder:
                    found = calibrate(others, language, Recognition(), Path(folder))
                    recognizer = Recognizer(language, Recognition(), found.profile)
                    after += [score([said(clip)], recognizer) for clip in judged]
        if before:
            row(f"{condition}, calibrated", before, after)


def talk_and_noise(clips: list[Clip], language: LanguageFiles) -> StartVector:
    """Let it hear what is no command; returns what it learnt from that."""
    scores, learnt = learn(language, shuffled(clips, 0), NOTHING)
    minutes = sum(len(samples(clip.path)) for clip in clips) / SAMPLE_RATE / 60
    alarms = sum(s.wrong for s in scores)
    print(f"\n{minutes:.0f} minutes of talk and noise, {alarms} false alarms, taught {learnt}\n")
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
        language = digit_language(Path(folder))
        digits([c for c in clips if c.condition == "human" and c.text in DIGITS], language)
    language = find_language(None)
    spoken = [c for c in clips if c.kind == "command"]
    calibrated(spoken, language)
    others = [c for c in clips if c.kind in ("talk", "noise")]
    commands(spoken, language, talk_and_noise(others, language))


if __name__ == "__main__":
    main(sys.argv[1:])
