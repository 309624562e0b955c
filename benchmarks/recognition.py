"""How well voz recognizes, beside plain pocketsphinx that refuses by a phone loop.

Run `python benchmarks/recognition.py DEV_MANIFEST PEOPLE_MANIFEST`. The first lists synthetic
voices in the conditions `us`, `gb` and `accent`, and noise, of which one recording is a kitchen;
the second lists people. `voz eval --help` tells what a manifest is. With
`--engine voz --engine whisper` it is Whisper that voz is beside (`whisper.py`).
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from statistics import mean
from tempfile import TemporaryDirectory
from typing import Annotated

import typer
import whisper  # noqa: F401  # adds itself to the engines
from machine import machine, one_line_errors, peak_megabytes
from msgspec.structs import replace
from rich.console import Console
from rich.progress import Progress

from voz.apps.evaluation.curves import curves
from voz.apps.evaluation.engines import EngineChoice
from voz.apps.evaluation.recognition_tasks import Task, in_processes, recognize, tasks_for
from voz.apps.evaluation.results import Result
from voz.apps.evaluation.scores import alarms_in
from voz.apps.evaluation.statistics import estimate
from voz.apps.evaluation.tables import alarm_rate_text, estimate_text
from voz.apps.recordings.manifest import Clip, read_manifest
from voz.errors import AudioError, ConfigError
from voz.language.build import build
from voz.language.language_files import LanguageFiles
from voz.settings import Recognition

LM = Path(__file__).parent.parent / "lm"
ENGINES = ["voz", "without-network", "pocketsphinx-phone-loop"]
KITCHEN = "dishes"
"""Part of the name of the recording of a kitchen."""

SNR = 10.0
"""How much louder than the kitchen the commands are, dB."""

NOTHING = "-"
"""Where there is nothing to count."""

Figures = dict[str, str]
"""The rows of one column: what is counted, and the figure."""


@dataclass(frozen=True)
class Part:
    """Recordings that are heard under one command list."""

    name: str  # of the list; empty for the robot's own, which has more rows than the others
    tasks: list[Task]  # the recordings
    language: LanguageFiles  # the language files of the list


@dataclass(frozen=True)
class Heard:
    """What became of a task, and the most memory that its process had taken until then, MB."""

    results: list[Result]
    megabytes: float


def robot_part(dev: Path, people: Path) -> Part:
    """Take the clips of both manifests, and the commands of the close voices in a kitchen too."""
    clips = [replace(clip, set="dev") for clip in read_manifest(dev)]
    kitchens = [c.path for c in clips if c.kind == "noise" and KITCHEN in c.file]
    if not kitchens:
        raise ConfigError(f'{dev}: lists no noise with "{KITCHEN}" in its name; add a kitchen')
    clips += [replace(clip, set="people") for clip in read_manifest(people)]
    # Commands come first, so that the long recordings do not count in their memory.
    clips.sort(key=lambda clip: clip.kind != "command")
    close = [clip for clip in clips if clip.kind == "command" and is_close(clip)]
    others = [clip for clip in clips if clip not in close]
    tasks = [*tasks_for(close, kitchens, [SNR], room=False), *tasks_for(others, [], [], room=False)]
    return Part("", tasks, LanguageFiles(LM))


def list_part(manifest: Path, folder: Path) -> Part:
    """Take the clips of another command list, which is made from the commands in its manifest."""
    clips = read_manifest(manifest)
    name = manifest.parent.name
    commands = folder / f"{name}.txt"
    commands.write_text("".join(f"{c.text}\n" for c in clips if c.kind == "command"))
    build(commands, folder / name)
    return Part(name, tasks_for(clips, [], [], room=False), LanguageFiles(folder / name))


def list_manifests(folder: Path | None) -> list[Path]:
    """Find the manifests that `tools/make_fixtures.py --lists` has made."""
    if folder is None:
        return []
    found = sorted(folder.glob("*/manifest.tsv"))
    if not found:
        raise ConfigError(f"{folder}: holds no */manifest.tsv; make them by make_fixtures.py")
    return found


def hear(task: Task, choice: EngineChoice) -> Heard:
    """Recognize a clip; this runs in processes of its own."""
    return Heard(recognize(task, choice), peak_megabytes())


def figures(engine: str, part: Part, heard: Sequence[Heard]) -> Figures:
    """Count what there is to say about an engine."""
    results = [result for each in heard for result in each.results]
    for result in results:
        if result.error is not None:
            raise AudioError(result.error)
    if part.name:
        return list_figures(part.name, results)
    commands = [h for h in heard if h.results[0].kind == "command" and h.results[0].snr is None]
    return {
        **command_figures(results),
        **other_figures([r for r in results if r.kind != "command"]),
        "expected calibration error": calibration(results) if engine == "voz" else NOTHING,
        "CPU for a command": f"{1000 * mean(h.results[0].cpu for h in commands):.1f} ms",
        "peak memory of the process": f"{max(h.megabytes for h in commands):.0f} MB",
    }


def command_figures(results: Iterable[Result]) -> Figures:
    """Count the commands of the robot."""
    commands = [result for result in results if result.kind == "command"]
    clean = [result for result in commands if result.snr is None]
    close = [result for result in clean if is_close(result)]
    accents = [r for r in clean if r.set == "dev" and r.condition == "accent"]
    return {
        "commands right and accepted, American and British": share(close, obeyed_right),
        "commands right and accepted, foreign accents": share(accents, obeyed_right),
        "`stop` by people right and accepted": share(
            [r for r in clean if r.set == "people" and r.text == "stop"], obeyed_right
        ),
        "`stop` missed, American and British": share(
            [r for r in close if r.text == "stop"], lambda r: not obeyed_right(r)
        ),
        f"right and accepted, lost at {SNR:g} dB of kitchen, American and British": lost(
            close, [result for result in commands if result.snr is not None]
        ),
    }


def other_figures(results: Sequence[Result]) -> Figures:
    """Count what should have moved nothing."""
    near_misses = [result for result in results if result.kind == "near-miss"]
    talk = [r for r in results if r.kind == "talk" and r.set == "people"]
    conditions = sorted({result.condition for result in talk})
    return {
        "near-misses let through, synthetic voices": share(
            [r for r in near_misses if r.set == "dev"], lets_through
        ),
        "near-misses let through, people": share(
            [r for r in near_misses if r.set == "people"], lets_through
        ),
        **{
            f"false alarms in people's talk, {name}": alarms(
                [result for result in talk if result.condition == name]
            )
            for name in conditions
        },
        "false alarms in recorded noise": alarms([r for r in results if r.kind == "noise"]),
    }


def list_figures(name: str, results: Sequence[Result]) -> Figures:
    """Count the commands and near-misses of another list."""
    return {
        f"{name}: commands right and accepted": share(
            [r for r in results if r.kind == "command"], obeyed_right
        ),
        f"{name}: near-misses let through": share(
            [r for r in results if r.kind == "near-miss"], lets_through
        ),
    }


def is_close(clip: Clip | Result) -> bool:
    """Tell whether a synthetic voice is close to a human one, and a native speaker's."""
    return clip.set == "dev" and clip.condition in ("us", "gb")


def obeyed_right(result: Result) -> bool:
    return result.is_right_and_accepted


def lets_through(result: Result) -> bool:
    return bool(result.obeyed)


def share(results: Sequence[Result], holds: Callable[[Result], bool]) -> str:
    return rate(results, [holds(result) for result in results], [1.0] * len(results))


def lost(clean: Iterable[Result], noisy: Sequence[Result]) -> str:
    """Compare each clip in noise with itself."""
    before = {result.file: obeyed_right(result) for result in clean}
    losses = [before[result.file] - obeyed_right(result) for result in noisy]
    return rate(noisy, losses, [1.0] * len(noisy))


def alarms(results: Sequence[Result]) -> str:
    return alarm_rate_text(alarms_in(results)) if results else NOTHING


def rate(results: Sequence[Result], counts: Sequence[float], of: Sequence[float]) -> str:
    """Divide, with the interval over the speakers."""
    if not results:
        return NOTHING
    return estimate_text(estimate(counts, of, [result.speaker for result in results]))


def calibration(results: Iterable[Result]) -> str:
    reliability = curves(results).reliability
    return f"{reliability.expected_error:.3f}" if reliability else NOTHING


def table(columns: dict[str, Figures]) -> str:
    """Write the engines side by side in markdown."""
    labels = next(iter(columns.values()))
    lines = [["", *columns], ["---"] * (len(columns) + 1)]
    lines += [[label, *(figures[label] for figures in columns.values())] for label in labels]
    return "\n".join(f"| {' | '.join(line)} |" for line in lines)


def compare(
    parts: Sequence[Part], engines: Sequence[str], jobs: int | None, console: Console
) -> dict[str, Figures]:
    """Let each engine hear all parts."""
    columns: dict[str, Figures] = {engine: {} for engine in engines}
    with Progress(console=console, transient=True) as progress:
        for engine in engines:
            for part in parts:
                choice = EngineChoice(engine, part.language, Recognition())
                outcomes = in_processes(partial(hear, choice=choice), part.tasks, jobs)
                description = f"{engine} {part.name}".strip()
                heard = progress.track(outcomes, len(part.tasks), description=description)
                columns[engine] |= figures(engine, part, list(heard))
    return columns


def main(
    dev: Annotated[Path, typer.Argument(help="Manifest of synthetic voices and noise.")],
    people: Annotated[Path, typer.Argument(help="Manifest of people.")],
    lists: Annotated[
        Path | None, typer.Option(help="What `make_fixtures.py --lists` has made: more rows.")
    ] = None,
    engine: Annotated[
        list[str] | None,
        typer.Option(help="As for `voz eval`; may be repeated. Of a program no memory is known."),
    ] = None,
    jobs: Annotated[
        int | None, typer.Option(min=1, help="Processes; else one for each core.")
    ] = None,
) -> None:
    """Print how well engines recognize, side by side.

    Example: python benchmarks/recognition.py dev/manifest.tsv people/manifest.tsv
    """
    console = Console(stderr=True)
    with TemporaryDirectory() as folder:
        others = [list_part(manifest, Path(folder)) for manifest in list_manifests(lists)]
        parts = [robot_part(dev, people), *others]
        columns = compare(parts, engine or ENGINES, jobs, console)
    print(f"{machine()}\n{len(parts[0].tasks)} recordings of the robot's commands\n")
    print(table(columns))


if __name__ == "__main__":
    with one_line_errors():
        typer.run(main)
