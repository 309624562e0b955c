"""Many clips through an engine, in many processes. An edge: it reads recordings and takes time."""

from __future__ import annotations

import multiprocessing
import resource
import signal
import time
from collections.abc import Callable, Iterable, Iterator
from concurrent.futures import ProcessPoolExecutor
from concurrent.futures.process import BrokenProcessPool
from contextlib import ExitStack
from dataclasses import dataclass
from functools import cache, partial
from pathlib import Path
from typing import TypeVar

import numpy as np
from msgspec.structs import replace

from voz.audio import SAMPLE_RATE, Samples
from voz.audio.files import read_blocks
from voz.errors import AudioError, ConfigError
from voz.evaluation import noise
from voz.evaluation.engines import Engine, EngineChoice, load_engine
from voz.evaluation.results import Clip, Result
from voz.live.quiet import quiet_libraries

Item = TypeVar("Item")
Outcome = TypeVar("Outcome")


@dataclass(frozen=True)
class Task:
    """A clip, and what is done to it before it is heard.

    Attributes:
        clip: the recording.
        room: whether it is played in a room.
        noise: recordings of which one is mixed in; empty for none.
        snr: how much louder the speech is than the noise, dB; None for no noise.
    """

    clip: Clip
    room: bool = False
    noise: tuple[Path, ...] = ()
    snr: float | None = None


def tasks_for(
    clips: Iterable[Clip], noise_paths: Iterable[Path], ratios: Iterable[float], room: bool
) -> list[Task]:
    """List what is to be heard: each clip as it is, and each command in noise.

    Args:
        clips: the recordings.
        noise_paths: recordings of noise, of which each command gets one.
        ratios: the signal-to-noise ratios that each command is mixed at, dB.
        room: whether all is played in a room.
    """
    paths, ratios = tuple(noise_paths), tuple(ratios)
    tasks = []
    for clip in clips:
        tasks.append(Task(clip, room))
        if clip.kind == "command":
            tasks += [Task(clip, room, paths, ratio) for ratio in ratios]
    return tasks


def recognise_all(
    tasks: Iterable[Task], choice: EngineChoice, processes: int | None
) -> Iterator[Result]:
    """Recognise clips, each as if it were alone.

    Args:
        tasks: the clips.
        choice: the engine.
        processes: how many work at the same time; None for one on each core.

    Returns:
        A result for each task, in their order; of a clip that cannot be read, the error.

    Raises:
        VozError: the engine cannot be loaded, or its process was killed.
    """
    return in_processes(partial(recognise, choice=choice), tasks, processes)


def in_processes(
    work: Callable[[Item], Outcome], items: Iterable[Item], processes: int | None
) -> Iterator[Outcome]:
    """Do the same work on many items, in many processes.

    Args:
        work: a function of a module, or a partial of one.
        items: what it is done on.
        processes: how many work at the same time; None for one on each core.

    Yields:
        The outcomes, in the order of the items.

    Raises:
        VozError: the work raised it, or its process was killed.
    """
    # A fork would copy the threads of the progress bar, and with them locks that nobody opens.
    spawn = multiprocessing.get_context("spawn")
    with ProcessPoolExecutor(processes, spawn, initializer=_begin) as pool:
        try:
            yield from pool.map(work, items)
        except BrokenProcessPool as error:
            raise ConfigError(
                "a process that recognises was killed, perhaps for want of memory; "
                "use fewer by --jobs"
            ) from error


def recognise(task: Task, choice: EngineChoice) -> Result:
    """Recognise one clip; the engine is loaded once in each process."""
    engine = _loaded(choice)
    clip = task.clip
    result = Result(
        clip.set, clip.file, clip.text, clip.speaker, clip.kind, clip.condition, task.snr
    )
    try:
        samples = prepared(task)
        before = _cpu_seconds()
        heard = engine(samples)
        used = _cpu_seconds() - before
    except AudioError as error:
        return replace(result, error=str(error))
    seconds = round(len(samples) / SAMPLE_RATE, 3)
    return replace(result, heard=tuple(heard), seconds=seconds, cpu=round(used, 5))


def prepared(task: Task) -> Samples:
    """Read a clip and do to it what the task says.

    The room, the recording of noise and the stretch of it are random, but the same each time for
    the same clip, and the same for all signal-to-noise ratios.

    Raises:
        AudioError: the clip or the noise cannot be read, or the noise is silent.
    """
    samples = _read(task.clip.path)
    rng = noise.generator_for(task.clip.file)
    if task.room:
        samples = noise.reverberated(samples, noise.room_response(rng))
    if task.snr is not None:
        path = task.noise[rng.integers(len(task.noise))]
        background = noise.stretch(_read(path), len(samples), rng)
        noise.check_not_silent(background, path)
        samples = noise.mixed(samples, background, task.snr)
    return samples


def _begin() -> None:
    """Leave Ctrl-C, which reaches all processes, to the one that started them, and stderr to it."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    _UNTIL_THE_END.enter_context(quiet_libraries())


@cache
def _loaded(choice: EngineChoice) -> Engine:
    return load_engine(choice)


def _read(path: Path) -> Samples:
    return np.concatenate(list(read_blocks(path)))


_UNTIL_THE_END = ExitStack()


def _cpu_seconds() -> float:
    """Processor time of this process and of the programs that it ran to their end."""
    programs = resource.getrusage(resource.RUSAGE_CHILDREN)
    return time.process_time() + programs.ru_utime + programs.ru_stime
