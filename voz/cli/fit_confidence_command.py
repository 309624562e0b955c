"""`voz fit-confidence`: makes the models of the confidence anew."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from voz.cli.eval_options import RECOGNIZING, JobsOption, ManifestsArgument
from voz.cli.options import LmOption, OverwriteOption
from voz.cli.text_io import show, with_bar
from voz.files import check_new, check_not_read, check_writable


def fit_confidence(
    manifests: ManifestsArgument,
    out: Annotated[Path, typer.Option(metavar="FILE.json", help="Where to write the models.")],
    jobs: JobsOption = None,
    lm: LmOption = None,
    overwrite: OverwriteOption = False,
) -> None:
    """Make the models of the confidence anew from recordings whose texts are known.

    One is for pocketsphinx alone, one for it with the network. Prints what would be accepted by
    both, judged by models that never heard the speaker. There must be half an hour of talk among
    the recordings: it says how often talk sounds like a command. `confidence = "FILE.json"` in the
    table [recognition] of a voz.toml makes voz judge by them.

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
