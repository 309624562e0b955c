"""What it wins, and what it costs, if the robot asks back where it is nearly sure.

Run `python benchmarks/questions.py FOLDER [--talk MANIFEST]`. FOLDER is one of `mix_rooms.py`. For
each stream prints how many of its commands are accepted, about how many more the robot would ask
the right question, about how many a wrong one, how many near-misses it would ask about, and how
long a right question takes with its answer. Talk is heard sentence by sentence.
"""

from __future__ import annotations

from concurrent.futures import ProcessPoolExecutor
from pathlib import Path
from typing import Annotated, NamedTuple

import numpy as np
import soundfile
import typer
from machine import machine, one_line_errors
from mix_rooms import read
from rooms import LISTING, Said

from voz.api.recognizer import Recognizer
from voz.apps.evaluation.statistics import alarm_rate
from voz.apps.evaluation.tables import alarm_rate_text
from voz.apps.recordings.manifest import Clip, read_manifest
from voz.audio import SAMPLE_RATE
from voz.cli.text_io import with_bar
from voz.config import default_commands
from voz.control.attention import SECONDS_PER_LETTER, question_about
from voz.errors import ConfigError
from voz.events import Utterance
from voz.files import read_json
from voz.language.language_files import find_language
from voz.settings import Ask, Recognition

ANSWER = 1.0
"""How long it takes to begin an answer, say it, and have it understood, s."""

ASK: tuple[Ask, ...] = ("standing", "always")
"""What a robot may ask about."""

PAUSE = np.zeros(SAMPLE_RATE, np.float32)


class Counts(NamedTuple):
    """What became of the commands and near-misses of a stream."""

    commands: int
    accepted: int
    asked_right: int
    asked_wrong: int
    near_misses: int
    asked_for_nothing: int
    seconds: list[float]


def recognizer() -> Recognizer:
    """A recognizer that tells what it is nearly sure of."""
    return Recognizer(find_language(None), Recognition(ask="always"))


def asked(heard: Utterance, ask: Ask = "always") -> str | None:
    """The question that the robot would ask, if any."""
    question = question_about(heard, ask, default_commands())
    return question.text if question else None


def hear_stream(job: tuple[Path, list[Said]]) -> Counts:
    """Hear a stream in which commands and near-misses are said."""
    path, said = job
    samples, _ = soundfile.read(path, dtype="int16")
    heard = recognizer().decode(samples, SAMPLE_RATE)
    right = wrong = accepted = nothing = 0
    seconds = []
    for start, end, text, _ in said:
        during = [h for h in heard if h.start < end and h.end > start]
        questions = [h for h in during if asked(h)]
        if text is None:
            nothing += bool(questions)
        elif any(h.accepted and h.text == text for h in during):
            accepted += 1
        elif any(p.text == text for h in questions for p in h.perhaps):
            right += 1
            seconds.append(SECONDS_PER_LETTER * len(asked(questions[0]) or "") + ANSWER)
        else:
            wrong += bool(questions)
    commands = sum(one.text is not None for one in said)
    return Counts(commands, accepted, right, wrong, len(said) - commands, nothing, seconds)


def hear_talk(clips: list[Clip]) -> tuple[float, list[int]]:
    """The hours of some talk, and how many questions the robot would ask, by `ASK`."""
    hears, samples, questions = recognizer(), 0, [0] * len(ASK)
    for clip in clips:
        sound = np.concatenate([read(clip), PAUSE])
        samples += len(sound)
        for heard in hears.decode(sound, SAMPLE_RATE):
            questions = [n + bool(asked(heard, a)) for n, a in zip(questions, ASK, strict=True)]
    return samples / SAMPLE_RATE / 3600, questions


def main(
    folder: Annotated[Path, typer.Argument(help="Streams of `mix_rooms.py`.")],
    talk: Annotated[list[Path] | None, typer.Option(help="A list of recorded talk.")] = None,
) -> None:
    """Print what asking back wins and costs.

    Example: python benchmarks/questions.py rooms --talk people/manifest.tsv
    """
    listing = read_json(folder / LISTING, dict[str, list[Said]], ConfigError, "name a folder")
    clips = [c for path in talk or () for c in read_manifest(path) if c.kind == "talk"]
    jobs = [(folder / f"{name}.wav", said) for name, said in listing.items()]
    with ProcessPoolExecutor() as pool:
        parts = pool.map(hear_talk, [clips[part::8] for part in range(8)])
        found = pool.map(hear_stream, jobs)
        counts = list(with_bar(found, "rooms", len(jobs)))
        spoken = list(with_bar(parts, "talk", 8))
    print(f"{machine()}\n")
    print("| room | accepted | asked right | asked wrong | near-misses asked | seconds |")
    print("| --- | --- | --- | --- | --- | --- |")
    for name, c in zip(listing, counts, strict=True):
        shares = [n / c.commands for n in (c.accepted, c.asked_right, c.asked_wrong)]
        nothing = c.asked_for_nothing / c.near_misses if c.near_misses else 0.0
        seconds = f"{np.mean(c.seconds):.1f}" if c.seconds else "-"
        cells = [*(f"{share:.3f}" for share in (*shares, nothing)), seconds]
        print(f"| {name} | {' | '.join(cells)} |")
    if clips:
        print()
        for place, ask in enumerate(ASK):
            rate = alarm_rate(sum(n[place] for _, n in spoken), sum(h for h, _ in spoken))
            print(f"Questions in talk, ask = {ask}: {alarm_rate_text(rate)}")


if __name__ == "__main__":
    with one_line_errors():
        typer.run(main)
