"""`voz eval` scores recordings whose texts are known; `voz fit-confidence` learns from them."""

from __future__ import annotations

import re
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from datetime import datetime
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from voz.cli.options import LmOption, OverwriteOption, RecognizerOptions, with_options
from voz.cli.text_io import info, show, warn, with_bar, write_text
from voz.config import Config
from voz.files import (
    atomic_write,
    check_new,
    check_not_read,
    check_writable,
    os_errors_as_config_error,
    shown_path,
)
from voz.printable import printable
from voz.process.signals import SOME_UNREADABLE
from voz.settings import Recognition

if TYPE_CHECKING:
    from voz.apps.evaluation.engines import EngineChoice
    from voz.apps.evaluation.plots import Plot
    from voz.apps.evaluation.recognition_tasks import Task
    from voz.apps.evaluation.report import Evaluation
    from voz.apps.evaluation.results import Result
    from voz.apps.evaluation.scores import OperatingPoint

MAX_EVAL_JOBS = 256
"""Processes; each takes 100 MB."""

JobsOption = Annotated[
    int | None,
    typer.Option(metavar="N", min=1, max=MAX_EVAL_JOBS, help="Processes; else one for each core."),
]

ManifestsArgument = Annotated[
    list[Path], typer.Argument(metavar="MANIFEST...", help="Lists of recordings, TSV.")
]
RECOGNIZING = "Recognizing"
"""What the bar says while it goes on."""


@dataclass
class EvalOptions(RecognizerOptions):
    """The options of `voz eval`."""

    html: Annotated[
        str | None,
        typer.Option(metavar="FILE", help="Write a page with figures, pictures, failures."),
    ] = None
    as_json: Annotated[
        str | None,
        typer.Option("--json", metavar="FILE|-", help="Write all figures and each clip's result."),
    ] = None
    compare: Annotated[
        Path | None,
        typer.Option(metavar="FILE", help="Compare with what --json has written before."),
    ] = None
    engine: Annotated[
        str,
        typer.Option(
            metavar="NAME",
            help="voz, without-network, plain-pocketsphinx, pocketsphinx-phone-loop, or "
            '"command:PROGRAM ARGUMENTS".',
        ),
    ] = "voz"
    snr: Annotated[
        str | None,
        typer.Option(
            metavar="DB,DB...", help="Also hear commands and near-misses in noise, as 20,10,5."
        ),
    ] = None
    noise: Annotated[
        Path | None, typer.Option(metavar="DIR|FILE", help="Recordings of noise for --snr.")
    ] = None
    reverb: Annotated[bool, typer.Option("--reverb", help="Play all in a room.")] = False
    jobs: JobsOption = None
    overwrite: OverwriteOption = False

    def check(self, settings: Config, heard: Sequence[Path]) -> None:
        """Refuse results that would replace what is read, or cannot be written."""
        # The old results may be replaced by new ones, but not by a page.
        self.check_written(settings, [self.as_json, self.html], heard)
        self.check_written(settings, [self.html], [self.compare])
        for name in (self.as_json, self.html):
            if name and name != "-":
                check_writable(Path(name))
                check_new(Path(name), self.overwrite)

    def describe(self, manifests: Sequence[Path], settings: Recognition) -> dict[str, str]:
        """Describe the options for the results."""
        return {
            "manifests": ", ".join(map(shown_path, manifests)),
            "engine": printable(self.engine),
            "search": settings.search,
            "threshold": _number(settings.threshold),
            "false alarms per hour": _number(settings.false_alarms_per_hour) or "the usual",
            "snr": printable(self.snr or ""),
            "noise": shown_path(self.noise) if self.noise else "",
            "reverb": "yes" if self.reverb else "no",
            "compare": shown_path(self.compare) if self.compare else "",
        }


def _number(value: float | None) -> str:
    return "" if value is None else f"{value:g}"


@with_options
def evaluate(options: EvalOptions, manifests: ManifestsArgument) -> None:
    """Score recordings whose texts are known: right, refused, false alarms, time.

    A manifest is a table with tabs: a line with the names of its columns, path (or file), text,
    speaker (or voice), kind and perhaps condition, then a line for each recording. Its kind is
    command, long (commands with " | " between them), near-miss, talk or noise.

    With columns start and end, in seconds, lines with the same path are what is said in a stream:
    each is scored by what is heard in its stretch, and what is obeyed elsewhere is out-of-nothing.

    --snr puts each command and near-miss into noise that goes on before and after it, so that it
    has to be found there. The ratio is that of speech without its pauses to the noise's mean.

    Prints the main figures. --html writes a page with all of them, what went wrong to be listened
    to, and its pictures as files beside it; --json writes them for programs. Exits with 3 when
    some recordings could not be read; the others are done.

    Example: voz eval audio_fixtures/manifest.tsv --html report.html
    """
    from voz.extras import require

    require("report", "jiwer", *(["matplotlib"] if options.html else []))
    from voz.apps.evaluation import report
    from voz.apps.evaluation.engines import EngineChoice
    from voz.apps.evaluation.noise import noise_options
    from voz.apps.evaluation.recognition_tasks import tasks_for
    from voz.apps.evaluation.report import machine
    from voz.apps.recordings.manifest import read_manifests

    settings = options.settings()
    if options.engine == "first-ear":
        options.engine = "without-network"
        warn(f"--engine first-ear is called {options.engine}")
    choice = EngineChoice(options.engine, options.language(settings), settings.recognition)
    ratios, noises = noise_options(options.snr, options.noise)
    compare = options.compare
    others = report.read_results(compare) if compare else None
    clips = read_manifests(manifests, streams=True)
    options.check(settings, [*manifests, *(clip.path for clip in clips), *noises])
    tasks = tasks_for(clips, noises, ratios, options.reverb)
    recognized = _recognized(tasks, choice, options.jobs)
    results = [result for _, result in recognized]
    points = _operating_points(results, choice) if options.engine == "voz" else []
    asked = options.describe(manifests, settings.recognition)
    made = datetime.now().astimezone().isoformat(timespec="seconds"), machine()
    evaluation = report.evaluate(results, asked, others, points, made)
    show_evaluation(evaluation, [task for task, _ in recognized], options)
    _report_errors(results)


def _recognized(
    tasks: Sequence[Task], choice: EngineChoice, jobs: int | None
) -> list[tuple[Task, Result]]:
    """Recognize all recordings, with a progress bar; yield each with its task."""
    from voz.apps.evaluation.recognition_tasks import recognize_all

    heard_in = with_bar(recognize_all(tasks, choice, jobs), RECOGNIZING, len(tasks))
    return [(task, one) for task, found in zip(tasks, heard_in, strict=True) for one in found]


def _report_errors(results: Iterable[Result]) -> None:
    """Report each recording that could not be read, and end if there are any."""
    failed = dict.fromkeys(result.error for result in results if result.error is not None)
    for error in failed:
        info(f"error: {error}")
    if failed:
        raise typer.Exit(SOME_UNREADABLE)


def _operating_points(results: Iterable[Result], choice: EngineChoice) -> list[OperatingPoint]:
    from voz.apps.evaluation.scores import operating_points
    from voz.recognition.engine import RecognitionEngine, confidence_model

    engine = RecognitionEngine(choice.language, choice.settings)
    return operating_points(results, confidence_model(engine), choice.settings, engine.commands)


def show_evaluation(evaluation: Evaluation, tasks: Sequence[Task], options: EvalOptions) -> None:
    """Show the main figures, and write all of them to `--html` and `--json`."""
    from voz.apps.evaluation import report
    from voz.events import to_json

    if "-" not in (options.html, options.as_json):
        show(*report.to_text(evaluation).split("\n"))
    names = []
    if options.html:
        names += _write_page(evaluation, tasks, options.html)
    if options.as_json:
        write_text(options.as_json, f"{to_json(evaluation)}\n")
        names += [options.as_json]
    if written := [name for name in names if name != "-"]:
        info(f"written: {', '.join(written)}")


def pictures_folder(page: Path) -> Path:
    """Return the folder for the pictures of a page, beside it."""
    return page.with_name(f"{page.stem}-pictures")


def _write_page(evaluation: Evaluation, tasks: Sequence[Task], name: str) -> list[str]:
    """Write the page and its pictures; return what was written."""
    from voz.apps.evaluation.plots import pictures
    from voz.apps.evaluation.report import failures, sounds_of_failures, to_html

    drawn = pictures(evaluation.curves, evaluation.scores.commands)
    sounds = sounds_of_failures(failures(evaluation.results), tasks)
    write_text(name, to_html(evaluation, {t: p.svg for t, p in drawn.items()}, sounds))
    if not drawn or not Path(name).is_file():  # a pipe, or a device
        return [name]
    folder = pictures_folder(Path(name))
    _write_pictures(folder, drawn)
    return [name, f"{shown_path(folder)}/"]


def _write_pictures(folder: Path, drawn: Mapping[str, Plot]) -> None:
    with os_errors_as_config_error(folder):
        folder.mkdir(exist_ok=True)
        for title, picture in drawn.items():
            stem = re.sub(r"[^a-z]+", "-", title.lower()).strip("-")
            with atomic_write(folder / f"{stem}.svg") as file:
                file.write(picture.svg)
            with atomic_write(folder / f"{stem}.png", "wb") as file:
                file.write(picture.png)


def fit_confidence(
    manifests: ManifestsArgument,
    out: Annotated[Path, typer.Option(metavar="FILE.json", help="Where to write the models.")],
    jobs: JobsOption = None,
    lm: LmOption = None,
    overwrite: OverwriteOption = False,
) -> None:
    """Make the models of the confidence anew from recordings whose texts are known.

    One is for pocketsphinx alone, one for it with the network, if that knows the language. Prints
    what would be accepted, judged by models that never heard the speaker. There must be half an
    hour of talk among the recordings: it says how often talk sounds like a command. `confidence =
    "FILE.json"` in the table [recognition] of a voz.toml makes voz judge by them.

    Example: voz fit-confidence mine/manifest.tsv talk/manifest.tsv --out mine.json
    """
    from voz.apps.evaluation.fit_confidence import (
        check_talk,
        collect_examples,
        describe_set,
        fit_models,
    )
    from voz.apps.evaluation.recognition_tasks import tasks_for
    from voz.apps.recordings.manifest import read_manifests
    from voz.language.language_files import find_language, read_commands
    from voz.recognition.confidence import save_models
    from voz.recognition.network.score import why_missing
    from voz.recognition.thresholds import threshold_for

    clips = read_manifests(manifests, streams=True)
    check_writable(out)
    check_not_read([out], [*manifests, *(clip.path for clip in clips)])
    check_new(out, overwrite)
    check_talk(clips)
    files = find_language(lm)
    with_network = why_missing(files) is None
    recordings = len(tasks_for(clips, [], [], room=False))
    found = list(with_bar(collect_examples(clips, lm, jobs), RECOGNIZING, recordings))
    fitted_on = [describe_set(clips, name) for name in sorted({c.set for c in clips})]
    models, judging = fit_models(found, fitted_on, read_commands(files), with_network)
    threshold = threshold_for(judging.model, judging.model.default_alarm_rate)
    show(
        f"accepted from {threshold:.3f} on, of how many; set, kind, condition, whether it is right"
    )
    for name, (share, number) in judging.accepted.items():
        show(f"{share:8.3f} {number:5}  {name}")
    save_models(models, out)
    show(f"written: {out}")
