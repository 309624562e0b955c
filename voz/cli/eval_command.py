"""`voz eval`: scores recordings whose texts are known."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from datetime import datetime
from typing import TYPE_CHECKING

import typer

from voz.cli.eval_options import RECOGNIZING, EvalOptions, ManifestsArgument
from voz.cli.eval_output import show_evaluation
from voz.cli.options import with_options
from voz.cli.text_io import info, with_bar
from voz.process.exit_codes import SOME_UNREADABLE

if TYPE_CHECKING:
    from voz.apps.evaluation.engines import EngineChoice
    from voz.apps.evaluation.operating_points import OperatingPoint
    from voz.apps.evaluation.recognize import Task
    from voz.apps.evaluation.results import Result


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
    from voz.apps.evaluation.machine import machine
    from voz.apps.evaluation.noise import noise_options
    from voz.apps.evaluation.recognize import tasks_for
    from voz.apps.recordings.manifest import read_manifests

    settings = options.settings()
    choice = EngineChoice(options.engine, options.language(settings), settings.recognition)
    ratios, noises = noise_options(options.snr, options.noise)
    compare = options.compare
    others = report.read_results(compare, in_noise=bool(ratios)) if compare else None
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
    from voz.apps.evaluation.recognize import recognize_all

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
    from voz.apps.evaluation.operating_points import operating_points
    from voz.language.language_files import read_commands
    from voz.recognition.recognizer import Recognizer, confidence_model

    model = confidence_model(Recognizer(choice.language, choice.settings))
    return operating_points(results, model, choice.settings, read_commands(choice.language))
