"""How often a robot misses its name, and hears it where nobody said it.

Run `python benchmarks/names.py NAMES TALK... [--also NAME]`. NAMES lists recordings of names by
people; each is said every 4 s in a quiet room, in a kitchen, beside motors, and amid the talk of
six people, 10 dB louder than these. TALK lists talk, the sentences of which are heard one by one,
and noise. Prints what voz misses and what wakes it, and the misses by the threshold at which each
name is heard in an hour of talk so many times, and what a name costs while people talk.
Published for six names, at one false alarm in ten hours and 10 dB (Picovoice/wake-word-benchmark):
Porcupine misses .027, Snowboy .32, pocketsphinx .52.
"""

from __future__ import annotations

import csv
import time
from collections.abc import Iterator, Sequence
from concurrent.futures import ProcessPoolExecutor
from functools import cache, partial
from pathlib import Path
from typing import Annotated, NamedTuple

import numpy as np
import typer
from machine import machine, one_line_errors
from mix_rooms import EVERY, FLOOR, Sound, background, is_scored, mixed, read

from voz.api.recognizer import Recognizer
from voz.apps.evaluation.statistics import AlarmRate, alarm_rate
from voz.apps.evaluation.tables import alarm_rate_text
from voz.apps.recordings.manifest import Clip, read_manifest
from voz.audio import SAMPLE_RATE
from voz.audio.sound_files import to_samples
from voz.cli.text_io import with_bar
from voz.language.language_files import find_language
from voz.recognition.language import load_language, with_more_words
from voz.recognition.name import NameFinder
from voz.recognition.network.score import PhonemeScorer, scorer_for
from voz.settings import Recognition

ROOMS = (("quiet", None), ("kitchen", 10), ("motors", 10), ("babble", 10))

RATES = (0.0, 0.2, 0.5, 1.0)
"""False alarms in an hour of talk."""

PIECE = 20 * SAMPLE_RATE
"""Samples of a stream that are heard at once for the scores."""

PAUSE = np.zeros(SAMPLE_RATE // 2, np.float32)
SEED = 1

SENTENCES_TIMED = 100

NEARLY = -5.0
"""A name with lower log-odds in a whole sentence is in no part of it either."""


def read_names(path: Path) -> list[Clip]:
    """Read a list of recordings; its columns are `path` and `text`, and perhaps others."""
    with path.open(encoding="utf-8", newline="") as file:
        rows = list(csv.DictReader(file, delimiter="\t"))
    return [
        Clip(path.stem, r["path"], path.parent / r["path"], r["text"], r["path"], "command", "")
        for r in rows
    ]


@cache
def network_of(*names: str) -> PhonemeScorer:
    """The network, which knows the words of names, too."""
    language = load_language(find_language(None))
    for name in names:
        language = with_more_words(language, Recognition(name=name))
    return scorer_for(language)


@cache
def recognizer(name: str) -> Recognizer:
    """A recognizer of a robot with a name; empty if it has none."""
    return Recognizer(find_language(None), Recognition(name=name))


def in_room(
    clips: Sequence[Clip], room: str, ratio: int | None, others: Sequence[Clip], seed: int
) -> tuple[Sound, list[tuple[float, float]]]:
    """A stream of names in a room, and when each is said, s."""
    rng = np.random.default_rng(seed)
    sound = None if ratio is None else background(room, EVERY * (len(clips) + 1), others, rng)
    stream, said = mixed(clips, sound, ratio, rng)
    return stream, [(begin, end) for begin, end, _, _ in said]


def hear_names(
    job: tuple[str, str, int | None], clips: Sequence[Clip], others: Sequence[Clip], seed: int
) -> tuple[list[bool], list[float]]:
    """Whether voz hears each recording of a name in a room, and the log-odds that it was said."""
    name, room, ratio = job
    stream, said = in_room([c for c in clips if c.text == name], room, ratio, others, seed)
    woken = [h for h in recognizer(name).decode(stream, SAMPLE_RATE) if h.named]
    network = network_of(name)
    names = NameFinder(network, name)
    scores = []
    for begin, end in said:
        part = stream[max(0, int((begin - 0.5) * SAMPLE_RATE)) : int((end + 0.5) * SAMPLE_RATE)]
        samples = to_samples(part, SAMPLE_RATE)
        match = names.find(samples, network.phone_likelihoods(samples), alone=True)
        scores.append(match.log_odds)
    heard = [any(h.start < end and h.end > begin for h in woken) for begin, end in said]
    return heard, scores


class Talk(NamedTuple):
    """Hours of talk; for each name the log-odds in each sentence, and false alarms."""

    hours: float
    scores: list[list[float]]
    alarms: list[int]


def hear_talk(clips: Sequence[Clip], names: Sequence[str]) -> Talk:
    """Look for names in talk, or noise, and have voz hear each piece in which one nearly fits."""
    network = network_of(*names)
    finders = [NameFinder(network, name) for name in names]
    rng, samples, alarms = np.random.default_rng(SEED), 0, [0] * len(names)
    scores = []
    for clip in clips:
        sound = np.concatenate([read(clip), PAUSE])
        sound += (FLOOR * rng.standard_normal(len(sound))).astype(np.float32)
        samples += len(sound)
        for at in range(0, len(sound), PIECE):
            piece = to_samples(sound[at : at + PIECE], SAMPLE_RATE)
            sounds = network.phone_likelihoods(piece)
            scores.append([f.find(piece, sounds, alone=True).log_odds for f in finders])
            for number, finder in enumerate(finders):
                if finder.best(sounds).log_odds >= NEARLY:
                    heard = recognizer(names[number]).decode(piece, SAMPLE_RATE)
                    alarms[number] += sum(bool(utterance.named) for utterance in heard)
    by_name = np.reshape(scores, (-1, len(names))).T.tolist()
    return Talk(samples / SAMPLE_RATE / 3600, by_name, alarms)


def in_parts(clips: Sequence[Clip], parts: int) -> Iterator[Sequence[Clip]]:
    """Split talk for several processes."""
    yield from (clips[part::parts] for part in range(parts))


def false_alarms(parts: Sequence[Talk], name: int) -> AlarmRate:
    """How often a name, by its number, was heard where nobody said it."""
    return alarm_rate(sum(part.alarms[name] for part in parts), sum(part.hours for part in parts))


def cost(sounds: Sequence[Sound], name: str) -> float:
    """The share of a core that some sentences take a robot with a name, or none."""
    decode = recognizer(name).decode
    decode(sounds[0], SAMPLE_RATE)
    begun = time.process_time()
    for sound in sounds:
        decode(sound, SAMPLE_RATE)
    return (time.process_time() - begun) * SAMPLE_RATE / sum(map(len, sounds))


def threshold_at(scores: Sequence[float], hours: float, rate: float) -> float:
    """The log-odds that are surpassed so many times in an hour."""
    return sorted(scores, reverse=True)[int(rate * hours)]


def main(
    names: Annotated[Path, typer.Argument(help="Lists names that are said.")],
    manifests: Annotated[list[Path], typer.Argument(help="List talk and noise.")],
    also: Annotated[list[str] | None, typer.Option(help="A name for false alarms alone.")] = None,
    share: Annotated[int, typer.Option(min=1, help="Hear one of so many sentences.")] = 1,
    seed: Annotated[int, typer.Option(help="Of the rooms.")] = SEED,
) -> None:
    """Print misses of names, and false alarms.

    Example: python benchmarks/names.py names/manifest.tsv people/manifest.tsv --also jarvis
    """
    clips = read_names(names)
    others = [clip for path in manifests for clip in read_manifest(path)]
    talk = [clip for clip in others if clip.kind == "talk" and is_scored(clip.speaker)][::share]
    noise = [clip for clip in others if clip.kind == "noise"]
    said = sorted({clip.text for clip in clips})
    every = [*said, *(also or ())]
    jobs = [(name, *room) for name in said for room in ROOMS]
    with ProcessPoolExecutor() as pool:
        parts = pool.map(partial(hear_talk, names=every), in_parts(talk, 16))
        in_noise = pool.map(partial(hear_talk, names=every), in_parts(noise, 4))
        heard = pool.map(partial(hear_names, clips=clips, others=others, seed=seed), jobs)
        of_talk = list(with_bar(parts, "talk", 16))
        of_noise = list(with_bar(in_noise, "noise", 4))
        in_rooms = dict(zip(jobs, with_bar(heard, "names", len(jobs)), strict=True))
    hours = sum(part.hours for part in of_talk)
    scores = {
        name: [s for part in of_talk for s in part.scores[at]] for at, name in enumerate(every)
    }
    print(f"{machine()}\n")
    print("| name | room | said | missed |", *(f" {rate:g} an hour |" for rate in RATES), sep="")
    print(f"|{' --- |' * (4 + len(RATES))}")
    for (name, room, ratio), (woken, fits) in in_rooms.items():
        title = room if ratio is None else f"{room} {ratio} dB"
        cells = [1 - np.mean(woken)]
        cells += [np.mean(np.array(fits) <= threshold_at(scores[name], hours, r)) for r in RATES]
        print(f"| {name} | {title} | {len(woken)} |", *(f" {cell:.3f} |" for cell in cells), sep="")
    print("\n| name | phones | false alarms in talk | in noise |\n| --- | --- | --- | --- |")
    for at, name in enumerate(every):
        alarms = " | ".join(alarm_rate_text(false_alarms(some, at)) for some in (of_talk, of_noise))
        print(f"| {name} | {network_of(name).count_phones(name)} | {alarms} |")
    sounds = [read(clip) for clip in talk[:SENTENCES_TIMED]]
    plain, named = cost(sounds, ""), cost(sounds, every[0])
    print(f"\nCPU while people talk: {plain:.1%} of a core; with a name {named:.1%}")


if __name__ == "__main__":
    with one_line_errors():
        typer.run(main)
