"""What is obeyed of commands that are said in rooms where a sound goes on all the time.

Run `python benchmarks/rooms.py FOLDER`. The folder holds streams, `NAME.wav`, and `said.json`: for
each name a list of what is said in it, as `[start, end, text, condition]` in seconds, with `null`
for the text of what is no command. Of a stream in whose list is nothing, nothing may be obeyed.
With `--lm` another list than the robot's is heard.
"""

from __future__ import annotations

from collections.abc import Sequence
from functools import partial
from pathlib import Path
from typing import Annotated, NamedTuple

import typer
from machine import machine, one_line_errors
from rich.console import Console
from rich.progress import Progress

from voz.apps.evaluation.engines import EngineChoice
from voz.apps.evaluation.recognition_tasks import Task, in_processes, recognize, tasks_for
from voz.apps.evaluation.results import OUT_OF_NOTHING, Result
from voz.apps.evaluation.scores import alarms_in
from voz.apps.evaluation.tables import alarm_rate_text
from voz.apps.recordings.manifest import Clip
from voz.errors import AudioError, ConfigError
from voz.files import read_json
from voz.language.language_files import LanguageFiles
from voz.settings import Recognition

LM = Path(__file__).parent.parent / "lm"
LISTING = "said.json"
NOTHING = "-"
"""Where there is nothing to count."""


class Said(NamedTuple):
    """Something in a stream: where, s, what, if it is a command, and by what kind of speaker."""

    start: float
    end: float
    text: str | None
    condition: str


def streams(folder: Path, names: Sequence[str]) -> list[Task]:
    """List what is to be heard.

    Args:
        folder: holds the streams.
        names: of those that are wanted; empty for all.

    Raises:
        ConfigError: the list of what is said cannot be used, or a stream is not in it.
    """
    path = folder / LISTING
    listing = read_json(path, dict[str, list[Said]], ConfigError, "name a folder with one")
    missing = [name for name in names if name not in listing]
    if missing or not listing:
        raise ConfigError(f"{path}: has no {' or '.join(missing) or 'stream'}; name one of its own")
    return [task for name in names or listing for task in stream(folder, name, listing[name])]


def stream(folder: Path, name: str, said: Sequence[Said]) -> list[Task]:
    """Make one stream of what is said in it; it is the only one, so that it has all conditions."""
    file = f"{name}.wav"
    whole = Clip(name, file, folder / file, "", file, "talk", "all")
    clips = [
        Clip(
            set=name,
            file=file,
            path=folder / file,
            text=one.text or "",
            speaker=file,
            kind="near-miss" if one.text is None else "command",
            condition=one.condition,
            start=one.start,
            end=one.end,
        )
        for one in said
    ]
    return tasks_for(clips or [whole], [], [], room=False)


def row(results: Sequence[Result], conditions: Sequence[str]) -> list[str]:
    """Count what became of a stream."""
    for result in results:
        if result.error is not None:
            raise AudioError(result.error)
    commands = [result for result in results if result.kind == "command"]
    near_misses = [result for result in results if result.kind == "near-miss"]
    others = [result for result in results if result.kind in ("talk", OUT_OF_NOTHING)]
    groups = [[r for r in commands if r.condition == condition] for condition in conditions]
    return [
        results[0].set,
        *(share(group) for group in (commands, *groups)),
        str(sum(result.is_wrongly_obeyed for result in commands)) if commands else NOTHING,
        obeyed(near_misses),
        alarm_rate_text(alarms_in(others)) if others else NOTHING,
    ]


def obeyed(near_misses: Sequence[Result]) -> str:
    if not near_misses:
        return NOTHING
    return f"{sum(bool(result.obeyed) for result in near_misses)} of {len(near_misses)}"


def share(commands: Sequence[Result]) -> str:
    if not commands:
        return NOTHING
    return f"{sum(r.is_right_and_accepted for r in commands) / len(commands):.3f}"


def table(streams: Sequence[Sequence[Result]]) -> str:
    """Write a line for each stream in markdown."""
    commands = [r for results in streams for r in results if r.kind == "command"]
    conditions = sorted({result.condition for result in commands})
    counts = ["taken for another", "near-misses obeyed", "obeyed out of nothing"]
    lines = [["stream", "right and accepted", *conditions, *counts]]
    lines += [["---"] * len(lines[0])]
    lines += [row(results, conditions) for results in streams]
    return "\n".join(f"| {' | '.join(line)} |" for line in lines)


def main(
    folder: Annotated[Path, typer.Argument(help=f"Streams, and {LISTING}.")],
    names: Annotated[
        list[str] | None, typer.Argument(metavar="STREAM...", help="Some of them; else all.")
    ] = None,
    engine: Annotated[str, typer.Option(help="As for `voz eval`.")] = "voz",
    lm: Annotated[Path, typer.Option(help="Language files.")] = LM,
    name: Annotated[str, typer.Option(help="A name that the robot has, and nobody says.")] = "",
    jobs: Annotated[
        int | None, typer.Option(min=1, help="Processes; else one for each core.")
    ] = None,
) -> None:
    """Print what is obeyed in streams of several commands.

    Example: python benchmarks/rooms.py rooms babble-10 talk
    """
    console = Console(stderr=True)
    tasks = streams(folder, names or [])
    choice = EngineChoice(engine, LanguageFiles(lm), Recognition(name=name))
    with Progress(console=console, transient=True, disable=not console.is_terminal) as progress:
        outcomes = in_processes(partial(recognize, choice=choice), tasks, jobs)
        heard = list(progress.track(outcomes, len(tasks), description=engine))
    print(f"{machine()}\n\n{table(heard)}")


if __name__ == "__main__":
    with one_line_errors():
        typer.run(main)
