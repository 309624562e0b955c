"""The options of `voz eval`."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Annotated

import typer

from voz.cli.options import OverwriteOption, RecognizerOptions
from voz.config import Config
from voz.files import check_new, check_writable, shown_path
from voz.printable import printable
from voz.settings import Recognition

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
            help="voz, first-ear, plain-pocketsphinx, pocketsphinx-phone-loop, or "
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
