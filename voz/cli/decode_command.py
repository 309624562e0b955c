"""`voz decode` recognizes recordings; `voz merge` joins what parts of a cluster made."""

from __future__ import annotations

import os
import sys
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from io import BufferedReader
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, cast

import typer

from voz.cli.options import OverwriteOption, ProfileOption, RecognizerOptions, finite, with_options
from voz.cli.text_io import MAX_INPUT_LINE, info, warn
from voz.config import Config, overridden
from voz.errors import ConfigError
from voz.process.signals import SOME_UNREADABLE

if TYPE_CHECKING:
    from voz.apps.batch.batch_decoder import BatchDecoder
    from voz.apps.batch.fingerprint import Header
    from voz.apps.batch.inputs import Inputs
    from voz.apps.batch.worker import SimulationOptions
    from voz.language.language_files import LanguageFiles
    from voz.recognition.interpreter import Details


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
    network: Annotated[
        bool | None,
        typer.Option(
            "--network/--no-network",
            help="Let the phoneme network decide, or leave it out: faster, with more errors.",
            show_default=False,
        ),
    ] = None
    ears: Annotated[int | None, typer.Option(min=1, max=2, hidden=True)] = None
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
        from voz.recognition.interpreter import Details

        is_of_words = self.textgrids or (self.out and self.out.endswith(CTM_ENDING))
        return Details(self.words or bool(is_of_words), self.best)

    @property
    def resumes(self) -> bool:
        """Whether what is in the output is kept."""
        return self.resume or self.retry_failed

    def settings(self, **others: Any) -> Config:
        """As for all that recognize, with or without the phoneme network."""
        settings = super().settings(**others)
        network = self.network
        if self.ears is not None:
            warn(
                f"--ears {self.ears} is called {'--network' if self.ears == 2 else '--no-network'}"
            )
            network = self.ears == 2
        return overridden(settings, {"recognition": {"use_network": network}})

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


MEGABYTE = 1_000_000


@with_options
def decode(
    options: DecodeOptions,
    paths: Annotated[
        list[str],
        typer.Argument(metavar="PATH...", help="Recordings, folders, manifests (.tsv), - ."),
    ],
) -> None:
    """Tell what is said in recordings of any format and rate, on all cores.

    `-` reads a list of them from standard input, a name a line, or a recording, or with --rate
    samples.

    Each recording has a row at least, in the order in which they are named. Exits with 3 when some
    could not be read, or were left out of a folder; the others are done.

    Example: voz decode audio_fixtures/long/session.wav

    Example: voz decode recordings/ --out heard.jsonl
    """
    from voz.process.standard_streams import quiet_libraries

    options.check()
    settings = options.settings()
    language = options.language(settings)
    with quiet_libraries():
        if "-" in paths and (options.rate is not None or _is_sound()):
            failed = _decode_pipe(options, settings, language, paths)
        else:
            failed = _decode_files(options, settings, language, paths)
    if failed:
        raise typer.Exit(SOME_UNREADABLE)


def _decode_pipe(
    options: DecodeOptions, settings: Config, language: LanguageFiles, paths: Sequence[str]
) -> bool:
    from voz.apps.batch.outcomes import SilentRow
    from voz.apps.batch.worker import decode_blocks
    from voz.audio.piped_sound import piped_blocks
    from voz.cli.decode_output import writer
    from voz.recognition.engine import RecognitionEngine
    from voz.recognition.profiles import load_profile

    if len(paths) > 1 or options.out or options.textgrids:
        raise ConfigError("-: sound from a pipe is decoded alone, to standard output")
    known = load_profile(options.profile, warn) if options.profile else None
    recognizer = RecognitionEngine(language, settings.recognition, known)
    write = writer(options)
    blocks = piped_blocks(_stdin(), options.rate, warn)
    outcome = decode_blocks(recognizer, blocks, "-", options.details, write)
    if isinstance(outcome.rows[0], SilentRow):
        write(outcome.rows[0])
    return outcome.failed


def _decode_files(
    options: DecodeOptions, settings: Config, language: LanguageFiles, paths: Sequence[str]
) -> bool:
    """Decode recordings on all cores; return whether some could not be read."""
    from voz.apps.batch.inputs import find_inputs
    from voz.apps.batch.locations import shown_name
    from voz.cli.decode_output import decode_to_file

    inputs = find_inputs(paths, options.glob, _names_on_stdin())
    warn(inputs.left_out_warning)
    _prepare_folders(options, [shown_name(name) for name in inputs.names])
    header, decoder = _batch_decoder(options, settings, language)
    if options.out:
        failed = decode_to_file(options, settings, header, inputs, decoder)
    else:
        failed = _show_all(options, inputs, decoder)
    return failed or bool(inputs.left_out)


def _prepare_folders(options: DecodeOptions, names: Sequence[str]) -> None:
    """Refuse to replace files that are written for each recording, unless asked."""
    from voz.apps.batch.alignments import TEXT_GRID_ENDING
    from voz.apps.batch.locations import EVENTS_ENDING, check_none_there
    from voz.files import os_errors_as_config_error

    if options.textgrids:
        with os_errors_as_config_error(options.textgrids):
            options.textgrids.mkdir(parents=True, exist_ok=True)
    for folder, ending in ((options.drive, EVENTS_ENDING), (options.textgrids, TEXT_GRID_ENDING)):
        if folder and not (options.resumes or options.overwrite):
            check_none_there(folder, names, ending)


def _batch_decoder(
    options: DecodeOptions, settings: Config, language: LanguageFiles
) -> tuple[Header, BatchDecoder]:
    """Collect what the results depend on, and who decodes."""
    from msgspec.structs import replace

    from voz.apps.batch.batch_decoder import BatchDecoder
    from voz.apps.batch.fingerprint import digest_of, header_for
    from voz.apps.batch.worker import WorkerSetup
    from voz.recognition.profiles import load_profile

    known = load_profile(options.profile, warn) if options.profile else None
    header = header_for(language, settings.recognition, known)
    details = options.details
    header = replace(header, words=details.words, best=details.best)
    memory = options.memory_limit * MEGABYTE
    folder = str(language.folder.resolve())
    setup = WorkerSetup(
        folder,
        settings.recognition,
        options.profile,
        memory,
        header.fingerprint,
        details=details,
    )
    if options.drive:
        simulation = _simulation_options(options.drive, settings, language, options)
        setup = replace(setup, simulation=simulation)
        rules = digest_of([simulation.settings.decode(), str(simulation.listening)])
        header = replace(header, drive=rules)
    isolated = options.out is not None
    return header, BatchDecoder(setup, options.jobs, options.time_limit, isolated, options.dask)


def _simulation_options(
    folder: Path, settings: Config, language: LanguageFiles, options: DecodeOptions
) -> SimulationOptions:
    """Return the rules by which recordings drive; refuses a list that drives and cannot stop."""
    from voz.apps.batch.simulated_run import simulation_options
    from voz.language.language_files import list_name, read_commands
    from voz.run.command_check import begins_listening, check_list, matched_settings

    commands = read_commands(language)
    settings = matched_settings(settings, commands)
    check_list(commands, settings.table, list_name(language))
    listening = options.listening or not begins_listening(commands, settings.table)
    return simulation_options(folder, settings, listening, options.pictures)


def _show_all(options: DecodeOptions, inputs: Inputs, decoder: BatchDecoder) -> bool:
    from voz.apps.batch.alignments import with_text_grids
    from voz.apps.batch.batch_decoder import in_input_order
    from voz.apps.batch.inputs import shard_of
    from voz.apps.batch.outcomes import with_manifest
    from voz.cli.decode_output import with_progress, with_warnings, writer

    names = shard_of(inputs.names, options.shard) if options.shard else inputs.names
    write = writer(options)
    finished = with_warnings(decoder.decode(names, range(len(names))))
    if options.textgrids:
        finished = with_text_grids(finished, options.textgrids)
    if not sys.stdout.isatty():  # in between results a bar would be in the way
        finished = with_progress(finished, len(names))
    failed = 0
    for outcome in in_input_order(finished):
        for row in with_manifest(outcome.rows, inputs.manifest.get(outcome.rows[0].file, {})):
            write(row)
        failed += outcome.failed
    return failed > 0


def _names_on_stdin() -> Iterator[str]:
    """Read file names from standard input, as bytes; raises ConfigError if it is sound."""
    while line := _stdin().readline(MAX_INPUT_LINE + 1):
        if b"\0" in line or len(line) > MAX_INPUT_LINE:
            raise ConfigError(
                "-: is no list, a name a line; pipe a recording, or samples with --rate"
            )
        yield os.fsdecode(line.rstrip(b"\r\n"))


def _stdin() -> BufferedReader:
    return cast(BufferedReader, sys.stdin.buffer)


def _is_sound() -> bool:
    """Whether a recording comes on standard input, and no list."""
    from voz.audio.piped_sound import is_sound

    return is_sound(_stdin())


def merge(
    shards: Annotated[
        list[str], typer.Argument(metavar="SHARD...", help="The outputs of all shards.")
    ],
    out: Annotated[str, typer.Option(metavar="FILE", help="Where the whole goes.")],
    overwrite: OverwriteOption = False,
) -> None:
    """Put the outputs of `voz decode --shard` together, in the order of the input.

    The whole is the same file that one run would have made.

    Example: voz merge heard-*.jsonl --out heard.jsonl
    """
    from voz.apps.batch.locations import check_output
    from voz.apps.batch.output import merge as merge_shards
    from voz.files import check_not_read

    check_not_read([out], shards)
    check_output(out, overwrite)
    count = merge_shards(shards, out)
    info(f"written: {out}, {count:,} recordings")
