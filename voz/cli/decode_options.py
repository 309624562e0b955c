"""The options of `voz decode`."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from voz.cli.options import OverwriteOption, ProfileOption, RecognizerOptions, finite
from voz.config import Config, overridden
from voz.errors import ConfigError

if TYPE_CHECKING:
    from voz.recognition.details import Details


@dataclass
class DecodeOptions(RecognizerOptions):
    """The options of `voz decode`."""

    as_json: Annotated[
        bool,
        typer.Option("--json", help="One line of JSON for each utterance, or file without any."),
    ] = False
    out: Annotated[
        str | None,
        typer.Option(
            metavar="FILE", help="Keep the results: .jsonl, .csv, .parquet or .ctm; or an address."
        ),
    ] = None
    resume: Annotated[
        bool, typer.Option("--resume", help="Go on with --out from where a run ended.")
    ] = False
    retry_failed: Annotated[
        bool, typer.Option("--retry-failed", help="The same, and try again what failed.")
    ] = False
    overwrite: OverwriteOption = False
    jobs: Annotated[
        int | None,
        typer.Option(metavar="N", min=1, max=1000, help="Processes; else one for each core."),
    ] = None
    glob: Annotated[
        str | None,
        typer.Option(metavar="PATTERN", help="Which files of folders, as *.wav or **/a*.flac."),
    ] = None
    rate: Annotated[
        float | None,
        typer.Option(metavar="HZ", help="Standard input is 16-bit samples of that rate."),
    ] = None
    ears: Annotated[
        int | None,
        typer.Option(
            metavar="1|2",
            min=1,
            max=2,
            help="1 leaves the phoneme network out: faster, with more errors.",
        ),
    ] = None
    time_limit: Annotated[
        float | None,
        typer.Option(
            metavar="S",
            min=0.1,
            max=1e6,
            callback=finite,
            help="For each file; else a minute and its length.",
        ),
    ] = None
    memory_limit: Annotated[
        int,
        typer.Option(
            metavar="MB", min=10, max=1_000_000_000, help="What a file may need in a worker."
        ),
    ] = 2000
    shard: Annotated[
        str | None,
        typer.Option(metavar="3/16", help="A part of the files; see `voz merge`."),
    ] = None
    drive: Annotated[
        Path | None,
        typer.Option(metavar="DIR", help="Keep what the robot would have done: its events."),
    ] = None
    pictures: Annotated[
        bool, typer.Option("--pictures", help="With --drive, draw its way too.")
    ] = False
    listening: Annotated[
        bool, typer.Option("--listening", help='With --drive, obey without "start speech".')
    ] = False
    words: Annotated[bool, typer.Option("--words", help="Add when each word was said.")] = False
    best: Annotated[
        int,
        typer.Option(
            metavar="N",
            min=0,
            max=100,
            help="Add the N commands that fit best.",
            show_default=False,
        ),
    ] = 0
    textgrids: Annotated[
        Path | None,
        typer.Option(metavar="DIR", help="Keep words and commands as Praat's TextGrids."),
    ] = None
    dask: Annotated[
        str | None,
        typer.Option(metavar="ADDRESS", help="The scheduler of a dask cluster that decodes."),
    ] = None
    profile: ProfileOption = None

    @property
    def details(self) -> Details:
        """What results have besides; formats of words need their times."""
        from voz.apps.batch.formats import CTM_ENDING
        from voz.recognition.details import Details

        is_of_words = self.textgrids or (self.out and self.out.endswith(CTM_ENDING))
        return Details(self.words or bool(is_of_words), self.best)

    @property
    def resumes(self) -> bool:
        """Whether what is in the output is kept."""
        return self.resume or self.retry_failed

    def settings(self, **others: Any) -> Config:
        """As for all that recognize, with or without the phoneme network."""
        settings = super().settings(**others)
        network = None if self.ears is None else self.ears == 2
        return overridden(settings, {"recognition": {"second_ear": network}})

    def check(self) -> None:
        """Refuse options that do nothing without another one."""
        if self.out is None:
            asked = {"--resume": self.resume, "--retry-failed": self.retry_failed}
            for name, given in asked.items():
                if given:
                    raise ConfigError(f"{name}: continues an output; name it with --out")
        if self.overwrite and not (self.out or self.drive or self.textgrids):
            raise ConfigError("--overwrite: replaces an output; name it with --out")
        if self.overwrite and self.resumes:
            raise ConfigError("--overwrite: starts again; leave it out to continue with --resume")
        if self.listening and self.drive is None:
            raise ConfigError("--listening: is about what a robot obeys; add --drive DIR")
        if self.pictures and self.drive is None:
            raise ConfigError("--pictures: draws the way of a robot; add --drive DIR")
        if self.out and self.as_json:
            raise ConfigError("--json: is for standard output; end the name of --out with .jsonl")
