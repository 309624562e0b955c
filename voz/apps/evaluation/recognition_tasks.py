"""Recognizes many clips with an engine, in many processes. An edge: it reads recordings."""

from __future__ import annotations

import resource
import time
from collections import deque
from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import dataclass
from functools import cache, partial
from pathlib import Path
from typing import Any, Protocol, TypeVar

from msgspec.structs import replace

from voz.apps.evaluation import noise
from voz.apps.evaluation.engines import Engine, EngineChoice, load_engine
from voz.apps.evaluation.results import OUT_OF_NOTHING, Result, Understood, empty_result
from voz.apps.recordings.manifest import Clip
from voz.audio import SAMPLE_RATE, Samples
from voz.audio.sound_files import read_samples
from voz.errors import AudioError, ConfigError
from voz.files import shown_path
from voz.process.worker_pool import WorkerDied, WorkerPool, cores, worker_pool

Stretch = tuple[float, float]
"""Start and end in a stream, s."""


class HasTimes(Protocol):
    """Something with a start and an end, s."""

    @property
    def start(self) -> float:
        """Where it begins, s."""

    @property
    def end(self) -> float:
        """Where it ends, s."""


Heard = TypeVar("Heard", bound=HasTimes)


def assign_to_stretches(
    heard: Sequence[Heard], stretches: Sequence[Stretch]
) -> tuple[list[list[Heard]], list[Heard]]:
    """Return the utterances in each stretch, and those outside of all.

    What overlaps with two stretches belongs to the earlier one, wherever that stands in the list.
    """
    parts: list[list[Heard]] = [[] for _ in stretches]
    rest: list[Heard] = []
    by_time = sorted(range(len(stretches)), key=stretches.__getitem__)
    for utterance in heard:
        overlaps = (n for n in by_time if _overlap(utterance, stretches[n]))
        number = next(overlaps, None)
        (rest if number is None else parts[number]).append(utterance)
    return parts, rest


def seconds_outside(stretches: Sequence[Stretch], seconds: float) -> float:
    """How much of a stream of so many seconds is in no stretch, s."""
    said = covered = 0.0
    for start, end in sorted(stretches):
        said += max(0.0, min(end, seconds) - max(start, covered))
        covered = max(covered, end)
    return max(0.0, seconds - said)


def _overlap(utterance: HasTimes, stretch: Stretch) -> bool:
    start, end = stretch
    return utterance.end > start and utterance.start < end


Item = TypeVar("Item")
Output = TypeVar("Output")


@dataclass(frozen=True)
class Task:
    """A recording, and what is done to it before it is heard."""

    clips: tuple[Clip, ...]  # one that is all of the recording, or the stretches of a stream
    room: bool = False  # whether it is played in a room
    noise: tuple[Path, ...] = ()  # recordings of which one is mixed in
    snr: float | None = None  # speech to noise, dB; None for no noise


def tasks_for(
    clips: Iterable[Clip], noise_paths: Iterable[Path], ratios: Iterable[float], room: bool
) -> list[Task]:
    """List what is to be heard: each recording as it is, and commands and near-misses in noise too.

    Stretches of one recording are a stream, which is heard once. Each clip gets one of the noises,
    at each of the signal-to-noise ratios, dB; with `room` all is played in a room.
    """
    paths, ratios = tuple(noise_paths), tuple(ratios)
    recordings: dict[object, list[Clip]] = {}
    for number, clip in enumerate(clips):
        is_whole = clip.start is None
        recordings.setdefault(number if is_whole else (clip.set, clip.path), []).append(clip)
    tasks = []
    for together in recordings.values():
        tasks.append(Task(tuple(together), room))
        (clip, *_) = together
        if clip.start is None and clip.kind in ("command", "near-miss"):
            tasks += [Task((clip,), room, paths, ratio) for ratio in ratios]
    return tasks


def recognize_all(
    tasks: Iterable[Task], choice: EngineChoice, processes: int | None
) -> Iterator[list[Result]]:
    """Recognize recordings, each as if it were alone; yields the results of each task, in order.

    Raises:
        VozError: the engine cannot be loaded.
    """
    return in_processes(partial(recognize, choice=choice), tasks, processes, _results_of_lost)


def in_processes(
    work: Callable[[Item], Output],
    items: Iterable[Item],
    processes: int | None,
    lost: Callable[[Item, str], Output] | None = None,
) -> Iterator[Output]:
    """Do the same work on many items in many processes; yields the outcomes in order.

    Args:
        work: a function of a module, or a partial of one: it is pickled.
        items: what it is done on.
        processes: how many work at the same time; None for one on each core.
        lost: makes the outcome of an item that two workers died of, of it and the reason; None
            raises ConfigError.
    """
    with worker_pool(processes or cores()) as pool:
        begun = deque((item, pool.schedule(work, args=(item,))) for item in items)
        while begun:
            item, future = begun.popleft()
            try:
                outcome = _result_or_retry(pool, work, item, future)
            except WorkerDied as death:
                if lost is None:
                    raise ConfigError(
                        f"a worker ended twice on the same recording ({death}), "
                        "perhaps out of memory; use fewer with --jobs"
                    ) from death
                outcome = lost(item, str(death))
            yield outcome


def _result_or_retry(
    pool: WorkerPool, work: Callable[[Item], Output], item: Item, future: Any
) -> Output:
    """Return the outcome of an item; another worker tries if its worker died."""
    try:
        outcome: Output = future.result()
    except WorkerDied:
        outcome = pool.schedule(work, args=(item,)).result()
    return outcome


def _results_of_lost(task: Task, how: str) -> list[Result]:
    error = f"{shown_path(task.clips[0].path)}: made its worker end twice ({how}); use --jobs 1"
    return [replace(empty_result(clip), snr=task.snr, error=error) for clip in task.clips]


def recognize(task: Task, choice: EngineChoice) -> list[Result]:
    """Recognize one recording; each process loads the engine once.

    Gives a result for each clip in it, and one for what was heard around them, if there is anything
    around. If it cannot be read, each has the error.
    """
    engine = _loaded(choice)
    results = [replace(empty_result(clip), snr=task.snr) for clip in task.clips]
    try:
        samples, background = prepared(task)
        stretches = _stretches(task, len(samples) / SAMPLE_RATE)
        before = _cpu_seconds()
        heard = engine(samples)
        used = _cpu_seconds() - before
    except AudioError as error:
        return [replace(result, error=str(error)) for result in results]
    parts, rest = assign_to_stretches(heard, stretches)
    outside = round(seconds_outside(stretches, len(samples) / SAMPLE_RATE), 3)
    cpu = round(used / len(results), 5)
    results = [
        replace(result, heard=tuple(part), seconds=round(end - start, 3), cpu=cpu, noise=background)
        for result, part, (start, end) in zip(results, parts, stretches, strict=True)
    ]
    return [*results, *([_rest(results[0], rest, outside)] if outside else [])]


def prepared(task: Task) -> tuple[Samples, str]:
    """Read a recording, with the room and the noise that the task asks for, and the noise's name.

    They are random, but the same each time for the same clip and for all signal-to-noise ratios.

    Raises:
        AudioError: the recording or the noise cannot be read, or the noise is silent.
    """
    clip = task.clips[0]
    samples = read_samples(clip.path)
    rng = noise.generator_for(clip.file)
    if task.room:
        samples = noise.reverberate(samples, noise.room_response(rng))
    if task.snr is None:
        return samples, ""
    path = task.noise[rng.integers(len(task.noise))]
    background = read_samples(path)
    if not background.any():
        raise AudioError(f"{path}: is silent, so it is no noise; use another recording")
    return noise.embed_in_noise(background, samples, task.snr, rng), shown_path(Path(path.stem))


def _stretches(task: Task, seconds: float) -> list[Stretch]:
    """Where each clip is, s; raises AudioError if the recording is over before it."""
    if task.snr is not None:
        return [(noise.NOISE_BEFORE, seconds - noise.NOISE_AFTER)]
    stretches = []
    for clip in task.clips:
        start, end = clip.start or 0.0, clip.end or seconds
        if start >= seconds:
            raise AudioError(
                f"{clip.path}: is over after {seconds:.1f} s, and the manifest has something at "
                f"{start:g} s; correct its times"
            )
        stretches.append((start, end))
    return stretches


def _rest(result: Result, heard: list[Understood], seconds: float) -> Result:
    """The result for what was heard around the clips; one of their results is given."""
    return replace(
        result,
        text="",
        speaker=result.file,
        kind=OUT_OF_NOTHING,
        condition=result.file,
        heard=tuple(heard),
        seconds=seconds,
        cpu=0.0,
        start=None,
        end=None,
    )


@cache
def _loaded(choice: EngineChoice) -> Engine:
    return load_engine(choice)


def _cpu_seconds() -> float:
    """Processor time of this process and of the programs that it has waited for, s."""
    programs = resource.getrusage(resource.RUSAGE_CHILDREN)
    return time.process_time() + programs.ru_utime + programs.ru_stime
