"""`voz eval` and `voz fit-confidence`: recordings whose texts are known."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from datetime import datetime
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from voz.cli.evaluation_options import Evaluating, JobsOption
from voz.cli.evaluation_out import put
from voz.cli.exit_codes import SOME_UNREADABLE
from voz.cli.options import LmOption, OverwriteOption, with_options
from voz.cli.terminal import show, tell, with_bar
from voz.files import check_new, check_not_read, check_writable

if TYPE_CHECKING:
    from voz.apps.evaluation.engines import EngineChoice
    from voz.apps.evaluation.operating_points import OperatingPoint
    from voz.apps.evaluation.recognize import Task
    from voz.apps.evaluation.results import Result

ManifestsArgument = Annotated[
    list[Path], typer.Argument(metavar="MANIFEST...", help="Lists of recordings, TSV.")
]
RECOGNIZING = "Recognizing"
"""What the bar says while it goes on."""


@with_options
def evaluate(options: Evaluating, manifests: ManifestsArgument) -> None:
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
    from voz.apps.evaluation import report
    from voz.apps.evaluation.engines import EngineChoice
    from voz.apps.evaluation.noise import noise_options
    from voz.apps.evaluation.recognize import tasks_for
    from voz.apps.recordings.manifest import read_manifests
    from voz.machine import machine

    report.require_libraries(pictures=options.html is not None)
    settings = options.settings()
    choice = EngineChoice(options.engine, options.language(settings), settings.recognition)
    ratios, noises = noise_options(options.snr, options.noise)
    compare = options.compare
    others = report.read_results(compare, in_noise=bool(ratios)) if compare else None
    clips = read_manifests(manifests, streams=True)
    options.check([*manifests, *(clip.path for clip in clips), *noises])
    tasks = tasks_for(clips, noises, ratios, options.reverb)
    recognized = _recognized(tasks, choice, options.jobs)
    results = [result for _, result in recognized]
    points = _operating_points(results, choice) if options.engine == "voz" else []
    asked = options.described(manifests, settings.recognition)
    made = datetime.now().astimezone().isoformat(timespec="seconds"), machine()
    evaluation = report.evaluate(results, asked, others, points, made)
    put(evaluation, [task for task, _ in recognized], options)
    _tell_errors(results)


def fit_confidence(
    manifests: ManifestsArgument,
    out: Annotated[Path, typer.Option(metavar="FILE.json", help="Where to write the models.")],
    jobs: JobsOption = None,
    lm: LmOption = None,
    overwrite: OverwriteOption = False,
) -> None:
    """Make the models of the confidence anew from recordings whose texts are known.

    One is for pocketsphinx alone, one for both ears. Prints what would be accepted by both, judged
    by models that never heard the speaker. There must be half an hour of talk among the
    recordings, to tell how often it sounds like a command. `confidence = "FILE.json"` in the table
    [recognition] of a voz.toml makes voz judge by them.

    Example: voz fit-confidence mine/manifest.tsv talk/manifest.tsv --out mine.json
    """
    from voz.apps.evaluation import fit_confidence as fitting
    from voz.apps.evaluation.examples import check_talk, collect_examples, describe_set
    from voz.apps.evaluation.recognize import tasks_for
    from voz.apps.recordings.manifest import read_manifests
    from voz.recognition.confidence_model import save_models
    from voz.recognition.thresholds import threshold_for

    clips = read_manifests(manifests, streams=True)
    check_writable(out)
    check_not_read([out], [*manifests, *(clip.path for clip in clips)])
    check_new(out, overwrite)
    check_talk(clips)
    recordings = len(tasks_for(clips, [], [], room=False))
    found = list(with_bar(collect_examples(clips, lm, jobs), RECOGNIZING, recordings))
    examples = [example for of_recording in found for example in of_recording.examples]
    alone = [example for of_recording in found for example in of_recording.alone]
    fitted_on = [describe_set(clips, name) for name in sorted({c.set for c in clips})]
    hours = sum(of_recording.talk for of_recording in found) / 3600
    commands = [clip for of_recording in found for clip in of_recording.commands]
    models, likely = fitting.fit_models(examples, alone, fitted_on, hours, commands)
    threshold = threshold_for(models.two_ears, models.two_ears.usual_alarms)
    show(
        f"accepted from {threshold:.3f} on, of how many; set, kind, condition, whether it is right"
    )
    counts = fitting.acceptance(examples, likely, threshold)
    for name, (share, number) in counts.items():
        show(f"{share:8.3f} {number:5}  {name}")
    save_models(models, out)
    show(f"written: {out}")


def _recognized(
    tasks: Sequence[Task], choice: EngineChoice, jobs: int | None
) -> list[tuple[Task, Result]]:
    """Recognize all recordings, with a bar that shows how far it is; gives each with its task."""
    from voz.apps.evaluation.recognize import recognize_all

    heard_in = with_bar(recognize_all(tasks, choice, jobs), RECOGNIZING, len(tasks))
    return [(task, one) for task, found in zip(tasks, heard_in, strict=True) for one in found]


def _tell_errors(results: Iterable[Result]) -> None:
    """Tell which recordings could not be read, each once, and end if there are such."""
    failed = dict.fromkeys(result.error for result in results if result.error is not None)
    for error in failed:
        tell(f"error: {error}")
    if failed:
        raise typer.Exit(SOME_UNREADABLE)


def _operating_points(results: Iterable[Result], choice: EngineChoice) -> list[OperatingPoint]:
    from voz.apps.evaluation.operating_points import operating_points
    from voz.language.generated.language_files import read_commands
    from voz.recognition.recognizer import Recognizer

    model = Recognizer(choice.language, choice.settings).model
    return operating_points(results, model, choice.settings, read_commands(choice.language))
