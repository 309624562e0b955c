"""`voz build-lm`: makes what the decoder reads from a list of commands."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from voz.cli.options import DEFAULT_SETTINGS_FILE, LanguageOption, with_options
from voz.cli.text_io import info, show, warn
from voz.process.signals import STALE, WRONG_CALL

if TYPE_CHECKING:
    from voz.config import Config
    from voz.language.command_source import CommandSource
    from voz.language.spoken_language import OtherLanguage

LIST_HERE = Path("lm/comandos_voz.txt")
"""What is built if nothing is named."""

MAX_LINES_SHOWN = 20
"""Lines of `tests.txt` that fail, and lines of the table of costs, that are shown."""


MAX_NAMES_SHOWN = 6
"""Commands of one line that are named."""


@dataclass
class BuildOptions:
    """The options of `voz build-lm`."""

    out: Annotated[
        Path | None, typer.Option(metavar="DIR", help="Where to write; else beside the list.")
    ] = None
    spoken: LanguageOption = None
    check: Annotated[
        bool, typer.Option("--check", help="Write nothing; exit with 1 if files are stale.")
    ] = False
    count: Annotated[
        bool, typer.Option("--count", help="Also show how many sentences each line gives.")
    ] = False
    sample: Annotated[
        int, typer.Option(metavar="N", min=0, help="Also show N sentences, drawn by chance.")
    ] = 0
    alike: Annotated[
        bool,
        typer.Option("--alike", help="Also show what sounds most alike: commands, other phrases."),
    ] = False
    every_pair: Annotated[
        bool, typer.Option("--all", help="Show all pairs that sound alike, not ten lines of them.")
    ] = False


@with_options
def build_lm(
    options: BuildOptions,
    listed: Annotated[
        Path | None,
        typer.Argument(
            metavar="[COMMANDS]",
            help="The list: sentences or templates, .ini, .yaml or .gram of others; or a folder. "
            f"Without it {LIST_HERE}, else voz's own.",
            show_default=False,
        ),
    ] = None,
) -> None:
    """Make the dictionary, language model and grammar from a list of commands.

    The language is English, or what `--language` or `[language]` in a voz.toml says.
    Warns of commands that sound alike. Sentences in a `tests.txt` beside the list must be commands,
    those after `!` must not, or nothing is written. A list that moves a robot needs a command that
    stops it; a voz.toml in the folder you are in says what commands do.

    Example: voz build-lm lm/comandos_voz.txt
    """
    from voz.config import Config, load_config, overridden
    from voz.language import build
    from voz.language.command_source import read_list
    from voz.language.formats.command_list import folder_of
    from voz.run.command_check import check_list, forgotten_alternatives, matched_settings

    settings = load_config(DEFAULT_SETTINGS_FILE) if DEFAULT_SETTINGS_FILE.is_file() else Config()
    if options.spoken:
        settings = overridden(settings, {"language": {"name": options.spoken}})
    commands = listed or _list_here(settings.language.name)
    source = read_list(commands, _spoken(settings))
    _check_expected(source, folder_of(commands))
    settings = matched_settings(settings, source.commands)
    check_list(source.commands, settings.table, str(commands))
    _show_more(options, source)
    folder = options.out or (folder_of(listed) if listed else LIST_HERE.parent)
    if options.check:
        _check_fresh(commands, folder, source)
        return
    result = build.build(commands, folder, source, options.every_pair)
    for warning in (*result.warnings, *forgotten_alternatives(source.commands, settings)):
        warn(warning)
    show(*map(_alternatives_line, source.commands.alternatives))
    show(f"{result.sentences:,} sentences, {result.words:,} words:")
    show(*(f"  {path}" for path in result.paths))


def _list_here(language: str) -> Path:
    """The list that is here; voz's own where there is none, nor files that another one made."""
    from voz.language.language_files import (
        PACKAGED_FOLDER,
        LanguageFiles,
        list_sources,
        packaged_files,
    )

    files = LanguageFiles(LIST_HERE.parent)
    made_from = [path.resolve() for path in list_sources(files)[:1]]
    is_own = any(path.is_relative_to(PACKAGED_FOLDER.resolve()) for path in made_from)
    if LIST_HERE.exists() or (files.dictionary.exists() and not is_own):
        return LIST_HERE
    return packaged_files(language).commands


def _alternatives_line(names: Sequence[str]) -> str:
    shown = ", ".join(f'"{name}"' for name in names[:MAX_NAMES_SHOWN])
    more = f" and {len(names) - MAX_NAMES_SHOWN} more" if len(names) > MAX_NAMES_SHOWN else ""
    return f"one line makes {len(names)} commands: {shown}{more}"


def _show_more(options: BuildOptions, source: CommandSource) -> None:
    from voz.language.command_source import everyday_neighbors, similar_pairs
    from voz.language.similarity_report import neighbor_table, similarity_table

    if options.count:
        _show_costs(source)
    if options.sample:
        show(*source.commands.sample(options.sample))
    if options.alike:
        show(*similarity_table(similar_pairs(source), options.every_pair).split("\n"))
        if not source.spoken:
            show(*neighbor_table(everyday_neighbors(source), options.every_pair).split("\n"))


def _check_fresh(commands: Path, folder: Path, source: CommandSource) -> None:
    """Show whether the files are what the list gives; end with an exit code if not."""
    from voz.language import build

    if stale := build.stale_files(commands, folder, source):
        names = ", ".join(stale)
        info(f"{folder}: not what {commands} gives: {names}; run `voz build-lm`")
        raise typer.Exit(STALE)
    show(f"{folder}: up to date")


def _spoken(settings: Config) -> OtherLanguage | None:
    if settings.language == type(settings.language)():
        return None
    from voz.language.spoken_language import configured_language

    return configured_language(settings.language)


def _check_expected(source: CommandSource, folder: Path) -> None:
    """Check the sentences in `tests.txt`; end with an exit code if one is wrong."""
    from voz.language.formats.command_list import EXPECTED_SENTENCES_FILE
    from voz.run.command_check import wrong_expectations

    path = folder / EXPECTED_SENTENCES_FILE
    failed = list(wrong_expectations(source.commands, path))
    for line in failed[:MAX_LINES_SHOWN]:
        info(line)
    if len(failed) > MAX_LINES_SHOWN:
        info(f"{path}: {len(failed) - MAX_LINES_SHOWN} more lines are not as they should be")
    if failed:
        raise typer.Exit(WRONG_CALL)


def _show_costs(source: CommandSource) -> None:
    """Show how many sentences there are, and which templates give most of them."""
    show(f"{len(source.commands):,} sentences")
    costs = source.compiled.costs if source.compiled else []
    if not costs:
        return
    rows = [("sentences", "states", "templates", "name", "where")]
    rows += [
        (f"{c.sentences:,}", f"{c.states:,}" if c.states else "", str(c.used_by), c.name, c.place)
        for c in sorted(costs, key=lambda cost: -cost.sentences)[:MAX_LINES_SHOWN]
    ]
    widths = [max(map(len, column)) for column in zip(*rows, strict=True)]
    show(*("  ".join(map(str.ljust, row, widths)).rstrip() for row in rows))
    if len(costs) > MAX_LINES_SHOWN:
        show(f"and {len(costs) - MAX_LINES_SHOWN} more")
