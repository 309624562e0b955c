"""Teach the phoneme network to hear in noise.

    python training/teach.py OUT --speech FOLDER --speech FOLDER

The teacher hears each clip clean; the student hears it in a room, through a device, in noise, at
any level, and learns to say the same (distillation, Hinton et al. 2015, arXiv:1503.02531), and the
phones that are known besides. `docs/training.md` says more.
"""

from __future__ import annotations

import math
import time
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from itertools import chain, zip_longest
from pathlib import Path
from typing import Annotated, NoReturn

import numpy as np
import torch
import typer
from jiwer import wer
from loss import Labels, Phones, loss_of
from mixing import NOTHING, at_level, augment
from network import Network
from noises import Sound
from numpy.random import Generator
from rich.progress import BarColumn, Progress, TextColumn, TimeElapsedColumn, TimeRemainingColumn
from speech import ENGLISH, Clip, Pool, load_pools, prepared, read, sounds_of
from torch import Tensor
from torch.utils.data import DataLoader, Dataset

from voz.audio import SAMPLE_RATE
from voz.recognition.network.phoneme_network import (
    BLOCKS,
    DEFAULT_NETWORK,
    MOMENT,
    SHORTEST,
    Description,
    UnknownNetworkError,
    read_network,
    write_network,
)

WARM_UP = 50
"""Steps in which the rate of learning rises; then it falls by a cosine to a twentieth."""

LAST_RATE = 0.05

LARGEST_GRADIENT = 2.0

WEIGHT_DECAY = 0.01

SILENCE = 1e-4
"""Root mean square of what a teacher hears where nothing is said."""

CUT = 0.5
"""How often clips are cut at random, as an end-pointer does: who only ever heard whole clips with
silence around them hears nothing in a stretch that begins with a word."""

CHECKED = 192
"""Clips of held-back speakers by which the network is judged."""

LITTLE_TRUST = 0.2
"""How much the teacher counts where it knows less than the labels: phones of other languages, and
what a voice was given to read."""

AHEAD = 4
"""Batches that each worker mixes before they are needed."""


@dataclass
class Batch:
    """Clips as the teacher and as the student hear them.

    Attributes:
        clean: batch x samples.
        noisy: the same clips, or a stretch of each.
        labels: the phones of each whole clip, where they are known.
        starts: the moment at which the stretch of each clip begins.
        language: what is spoken.
        trust: how much the teacher counts where the phones are known, from 0 to 1.
    """

    clean: Tensor
    noisy: Tensor
    labels: Labels
    starts: Sequence[int]
    language: str
    trust: float


def teach(
    out: Annotated[Path, typer.Argument(help="Folder of the results; a run goes on from there.")],
    speech: Annotated[
        list[Path], typer.Option(help="A folder with a manifest.tsv; may be given again.")
    ],
    steps: Annotated[int, typer.Option(min=1, help="Batches in all.")] = 20_000,
    batch: Annotated[int, typer.Option(min=2, help="Clips in a batch.")] = 16,
    rate: Annotated[
        float, typer.Option(min=1e-7, max=0.1, help="The highest rate of learning.")
    ] = 4e-4,
    start: Annotated[Path, typer.Option(help="The weights to begin with.")] = DEFAULT_NETWORK,
    teacher: Annotated[
        Path, typer.Option(help="The weights that tell what is said.")
    ] = DEFAULT_NETWORK,
    seed: Annotated[int, typer.Option(help="Of all that is random.")] = 1,
    check_every: Annotated[int, typer.Option(min=1, help="Steps between two checks.")] = 250,
    threads: Annotated[int, typer.Option(min=1, help="Processor cores that learn.")] = 1,
    workers: Annotated[
        int, typer.Option(min=0, help="Processes that mix what is heard, as a GPU needs.")
    ] = 0,
    first_block: Annotated[
        int,
        typer.Option(
            min=0,
            max=BLOCKS,
            help="What lies below this block stays as voz has it, and the file is without it.",
        ),
    ] = 0,
    origin: Annotated[
        str, typer.Option(help="What the file says of the data it was made from.")
    ] = "",
) -> None:
    """Teach the network, and keep the weights that do best on speakers it never learned from.

    Example: python training/teach.py taught --speech recordings --speech words --steps 5000

    With a GPU: python training/teach.py taught --speech words --batch 64 --workers 16
    """
    torch.set_num_threads(threads)
    device = torch.device("cuda" if torch.cuda.is_available() else "cpu")
    out.mkdir(parents=True, exist_ok=True)
    try:
        wise, first = read_network(teacher), read_network(start)
        pool, held_back = load_pools(speech)
    except (UnknownNetworkError, OSError, KeyError) as error:
        fail(f"{error}; give files of weights, and folders with a manifest.tsv")
    if not pool.groups or not held_back:
        fail("too few speakers: some are held back to judge the network by; give more")
    student = Network(first.weights).to(device)
    student.keep_below(first_block)
    base = read_network(DEFAULT_NETWORK)
    if not student.keeps_all_of(base.weights):
        fail(f"--first-block {first_block}: what lies below it differs from the network of voz")
    run = Run(
        student,
        Network(wise.weights).to(device).eval(),
        all_phones(first.description.symbols, pool, device),
        pool,
        out,
        Description(
            symbols=first.description.symbols,
            origin=f"{first.description.origin}; taught {steps} steps, seed {seed}: {origin}",
            license=first.description.license,
            base=base.fingerprint if first_block else None,
        ),
    )
    batches = DataLoader(
        Batches(pool, batch, seed),
        batch_size=None,
        sampler=range(run.step, steps),
        num_workers=workers,
        prefetch_factor=AHEAD if workers else None,
    )
    run.go(chosen(held_back), batches, steps=steps, rate=rate, seed=seed, every=check_every)


def all_phones(symbols: Sequence[str], pool: Pool, device: torch.device) -> dict[str, Phones]:
    """The phones of each language: of English all, of others those that a clip has."""
    used: dict[str, set[str]] = {ENGLISH: {*sounds_of(ENGLISH)}}
    for clip in chain.from_iterable(pool.groups):
        used.setdefault(clip.language, set()).update(clip.phones or ())
    return {
        language: Phones(
            symbols, {p: s for p, s in sounds_of(language).items() if p in phones}, device
        )
        for language, phones in used.items()
    }


def fail(why: str) -> NoReturn:
    """End the program with one line."""
    typer.echo(f"teach.py: {why}", err=True)
    raise typer.Exit(2)


class Run:
    """A run of teaching; what is in its folder lets it go on after it was interrupted."""

    def __init__(
        self,
        student: Network,
        teacher: Network,
        phones: Mapping[str, Phones],
        pool: Pool,
        out: Path,
        description: Description,
    ) -> None:
        self.student, self.teacher, self.phones, self.pool = student, teacher, phones, pool
        self.device = student.get_buffer("bands").device
        learned = [tensor for tensor in student.parameters() if tensor.requires_grad]
        self.optimizer = torch.optim.AdamW(learned, weight_decay=WEIGHT_DECAY)
        self.state, self.best_file, self.log = out / "state.pt", out / "best.npz", out / "log.tsv"
        self.description = description
        self.step, self.best = 0, math.inf
        if self.state.exists():
            kept = torch.load(self.state, map_location=self.device, weights_only=True)
            student.load_state_dict(kept["student"])
            self.optimizer.load_state_dict(kept["optimizer"])
            self.step, self.best = kept["step"], kept["best"]

    def go(
        self,
        held_back: Sequence[Clip],
        batches: Iterable[Batch],
        *,
        steps: int,
        rate: float,
        seed: int,
        every: int,
    ) -> None:
        """Learn until the last step."""
        with Progress(
            TextColumn("{task.completed}/{task.total}"),
            BarColumn(),
            TextColumn("loss {task.fields[loss]}  phone errors {task.fields[errors]}"),
            TimeElapsedColumn(),
            TimeRemainingColumn(),
        ) as progress:
            shown = progress.add_task("", total=steps, completed=self.step, loss="", errors="")
            if self.step == 0:
                progress.update(shown, errors=self.check(held_back, [0.0, 0.0]))
            losses: list[list[float]] = []
            for batch in batches:
                rng = np.random.default_rng([seed, self.step, 1])
                losses.append(self.learn(batch, rate_at(self.step, steps, rate), rng))
                self.step += 1
                mean = np.mean(losses[-50:], axis=0)
                progress.update(shown, advance=1, loss=f"{mean[0]:.3f} + {mean[1]:.3f}")
                if self.step % every == 0 or self.step == steps:
                    progress.update(shown, errors=self.check(held_back, np.mean(losses, axis=0)))
                    losses.clear()

    def learn(self, batch: Batch, rate: float, rng: Generator) -> list[float]:
        """Take one step; returns the two parts of the loss before it, nats."""
        for group in self.optimizer.param_groups:
            group["lr"] = rate
        heard = self.student(batch.noisy.to(self.device))
        said, labels = self.taught(batch, heard.shape[1])
        phones = self.phones[batch.language]
        parts = loss_of(heard, said, labels, phones, rng, most_trust=batch.trust)
        self.optimizer.zero_grad()
        (parts[0] + parts[1]).backward()
        torch.nn.utils.clip_grad_norm_(self.student.parameters(), LARGEST_GRADIENT)
        self.optimizer.step()
        return [part.item() for part in parts]

    @torch.no_grad()
    def taught(self, batch: Batch, moments: int) -> tuple[Tensor, Labels]:
        """What the teacher hears in what the student hears, and the phones that are known of it."""
        whole = self.teacher(batch.clean.to(self.device))
        if whole.shape[1] == moments:
            return whole, batch.labels
        stretches = zip(whole, batch.starts, strict=True)
        said = torch.stack([clip[start : start + moments] for clip, start in stretches])
        phones = self.phones[batch.language]
        return said, phones.within(whole, batch.labels, batch.starts, moments)

    def check(self, held_back: Sequence[Clip], losses: Sequence[float]) -> str:
        """Judge the network, keep it if it is the best, and keep what a later run goes on from."""
        errors = [phone_errors(self, clips) for clips in by_kind(held_back)]
        clean, noisy = np.mean(errors, axis=0).tolist()
        score = clean + noisy
        is_best = score < self.best
        if is_best:
            self.best = score
            write_network(self.best_file, self.student.weights(), self.description)
        torch.save(
            {
                "student": self.student.state_dict(),
                "optimizer": self.optimizer.state_dict(),
                "step": self.step,
                "best": self.best,
            },
            self.state,
        )
        with self.log.open("a", encoding="utf-8") as file:
            row = [
                time.strftime("%H:%M:%S"),
                self.step,
                *losses,
                *chain.from_iterable(errors),
                "best" if is_best else "",
            ]
            print(*(f"{x:.4f}" if isinstance(x, float) else x for x in row), sep="\t", file=file)
        return f"{clean:.3f} clean, {noisy:.3f} in noise (best of both {self.best / 2:.3f})"


def phone_errors(run: Run, clips: Sequence[Clip]) -> tuple[float, float]:
    """The share of phones that are read wrongly, clean and in noise, of clips with known phones."""
    readings: dict[bool, list[str]] = {False: [], True: []}
    for number, clip in enumerate(clips):
        rng = np.random.default_rng(number)
        pause = number % 2 * SAMPLE_RATE // 5  # half of them begin and end with a word
        clean = with_silence(np.pad(at_level(read(clip.path)), pause), rng)
        for is_noisy, sound in ((False, clean), (True, augment(clean, run.pool, rng))):
            with torch.no_grad():
                symbols = run.student(torch.tensor(sound)[None].to(run.device))[0]
            readings[is_noisy].append(run.phones[clip.language].reading(symbols))
    wanted = [" ".join(clip.phones or ()) for clip in clips]
    return wer(wanted, readings[False]), wer(wanted, readings[True])


def by_kind(clips: Sequence[Clip]) -> list[list[Clip]]:
    """Those in English and those in other languages, if there are any."""
    kinds = [[c for c in clips if (c.language == ENGLISH) is english] for english in (True, False)]
    return [clips for clips in kinds if clips]


def chosen(held_back: Sequence[Clip]) -> list[Clip]:
    """Clips to judge by: some of each held-back speaker in turn, with known phones, none long.

    As many are in English as in other languages.
    """
    kinds = by_kind([clip for clip in held_back if clip.phones and clip.seconds < 5])
    return [clip for clips in kinds for clip in _in_turn(clips)[: CHECKED // len(kinds)]]


def _in_turn(clips: Sequence[Clip]) -> list[Clip]:
    by_speaker: dict[str, list[Clip]] = {}
    for clip in clips:
        by_speaker.setdefault(clip.speaker, []).append(clip)
    rounds = zip_longest(*(reversed(own) for own in by_speaker.values()))
    return [clip for each in rounds for clip in each if clip]


class Batches(Dataset[Batch]):
    """The batch of each step, whoever makes it."""

    def __init__(self, pool: Pool, size: int, seed: int) -> None:
        self.pool, self.size, self.seed = pool, size, seed

    def __getitem__(self, step: int) -> Batch:
        return make_batch(self.pool, self.size, np.random.default_rng([self.seed, step]))


def make_batch(pool: Pool, size: int, rng: Generator) -> Batch:
    """Clips as the teacher and the student hear them; all as long as the longest."""
    clips = pool.batch(size, rng)
    pairs = [prepared(clip, rng) for clip in clips]
    length = max(len(sound) for sound, _ in pairs)
    clean, noisy, labels = [], [], []
    for sound, phones in pairs:
        is_speech = rng.random() >= NOTHING
        whole = np.zeros(length, np.float32)
        if is_speech:
            begin = int(rng.integers(length - len(sound) + 1))
            whole[begin : begin + len(sound)] = at_level(sound)
        whole = with_silence(whole, rng)
        clean.append(whole)
        noisy.append(augment(whole, pool, rng))
        labels.append(phones if is_speech else None)
    starts, kept = [0] * len(noisy), length
    if rng.random() < CUT:
        kept = int(rng.uniform(min(SHORTEST, length), length))
        starts = rng.integers((length - kept) // MOMENT + 1, size=len(noisy)).tolist()
    stretches = [
        clip[start * MOMENT : start * MOMENT + kept]
        for clip, start in zip(noisy, starts, strict=True)
    ]
    sounds = torch.tensor(np.array(clean)), torch.tensor(np.array(stretches))
    is_known = clips[0].language == ENGLISH and not clips[0].is_exact
    trust = 1.0 if is_known else LITTLE_TRUST
    return Batch(*sounds, labels, starts, clips[0].language, trust)


def with_silence(sound: Sound, rng: Generator) -> Sound:
    """No microphone gives zeros."""
    return (sound + SILENCE * rng.standard_normal(len(sound))).astype(np.float32)


def rate_at(step: int, steps: int, highest: float) -> float:
    """The rate of learning: up in a line, then down by a cosine."""
    down = 0.5 + 0.5 * math.cos(math.pi * step / steps)
    return highest * min(1, (step + 1) / WARM_UP) * (LAST_RATE + (1 - LAST_RATE) * down)


if __name__ == "__main__":
    typer.run(teach)
