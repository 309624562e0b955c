"""What several subcommands share: options, each declared once, and how the help lists them."""

from __future__ import annotations

import functools
import inspect
import math
from collections.abc import Callable, Iterable
from dataclasses import Field, dataclass, fields
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, get_type_hints

import typer
from typer.core import TyperGroup

from voz.cli.text_io import info, warn
from voz.config import Config, load_config, overridden
from voz.files import check_not_read
from voz.process.setup import LEAST_MEMORY, check_memory
from voz.settings import SpokenLanguage

if TYPE_CHECKING:
    from voz.language.language_files import LanguageFiles

DEFAULT_SETTINGS_FILE = Path("voz.toml")
"""The settings where none are named: those of the folder that the user is in."""

LmOption = Annotated[
    str | None,
    typer.Option("--lm", metavar="DIR", help="Language files; else lm/ here, else voz's own."),
]
LanguageOption = Annotated[
    str | None,
    typer.Option("--language", metavar="NAME", help="What is spoken, as es: see `voz language`."),
]
ProfileOption = Annotated[
    str | None, typer.Option("--profile", metavar="NAME", help="Who speaks: see `voz calibrate`.")
]
ZeroconfOption = Annotated[
    bool,
    typer.Option(
        "--zeroconf/--no-zeroconf",
        help="Let Home Assistant find it, if --wyoming names an address that others reach.",
    ),
]
OverwriteOption = Annotated[
    bool, typer.Option("--overwrite", help="Replace results that are there already.")
]
DeviceOption = Annotated[
    str | None,
    typer.Option("-d", "--device", metavar="N|NAME", help="Which microphone: see `voz devices`."),
]


def finite(value: float | None) -> float | None:
    """Refuse infinity, and NaN, which is in every range of typer's."""
    if value is not None and not math.isfinite(value):
        raise typer.BadParameter(f"{value} is no number; give one with an end.")
    return value


@dataclass
class CommonOptions:
    """The options of all subcommands that need the language files and settings."""

    lm: LmOption = None
    config: Annotated[
        Path | None,
        typer.Option("--config", metavar="FILE", help="Settings; else a voz.toml here."),
    ] = None
    spoken: LanguageOption = None
    verbose: Annotated[bool, typer.Option("-v", "--verbose", help="Tell what is used.")] = False

    def settings(self, **others: Any) -> Config:
        """Read the settings; options given as `others` take their place, as in `overridden`."""
        settings = load_config(self.settings_file) if self.settings_file else Config()
        for line in settings.old_names:
            self._warn_once(line)
        return overridden(settings, {"lm": self.lm, "language": {"name": self.spoken}, **others})

    @functools.cached_property
    def _warn_once(self) -> Callable[[str], None]:
        """Write a warning unless it was written: a run reads its settings again."""
        return functools.cache(warn)

    @functools.cached_property
    def settings_file(self) -> Path | None:
        """Where the settings are; None if they are in no file."""
        if self.config or not DEFAULT_SETTINGS_FILE.is_file():
            return self.config
        info(f"settings: {DEFAULT_SETTINGS_FILE}")
        return DEFAULT_SETTINGS_FILE

    def language(self, settings: Config) -> LanguageFiles:
        """Find language files that can be used; warn if their list has changed."""
        from voz.language.language_files import check_files, find_language, stale_warning

        language = find_language(settings.lm, settings.language)
        check_files(language)
        if settings.language != SpokenLanguage():
            from voz.language.language_files import read_language_info
            from voz.language.spoken_language import check_same_language

            check_same_language(read_language_info(language), settings.language, language.folder)
        if self.verbose:
            info(f"language files: {language.folder.resolve()}")
            info(f"phoneme network: {_network_status(settings, language)}")
        warn(stale_warning(language))
        return language

    def check_written(
        self,
        settings: Config,
        written: Iterable[str | Path | None],
        read: Iterable[str | Path | None],
    ) -> None:
        """Refuse to write what is read: the files given, the settings, the language files."""
        from voz.language.language_files import FILE_STEM, find_language

        language = find_language(settings.lm, settings.language).folder.glob(f"{FILE_STEM}.*")
        named = (self.settings_file, settings.recognition.confidence, settings.recognition.network)
        check_not_read(filter(None, written), filter(None, (*read, *named, *language)))


def _network_status(settings: Config, language: LanguageFiles) -> str:
    from voz.recognition.network.phoneme_network import fingerprint_of
    from voz.recognition.network.score import network_file, why_missing

    network = settings.recognition.network
    off = None if settings.recognition.use_network else "off in the settings"
    if missing := off or why_missing(language, network):
        return f"none ({missing}); pocketsphinx decides alone"
    return fingerprint_of(network_file(language, network))


@dataclass
class RecognizerOptions(CommonOptions):
    """The options of all subcommands that recognize speech."""

    name: Annotated[
        str | None,
        typer.Option(metavar="TEXT", help='The robot\'s name, such as "hey robot".'),
    ] = None
    search: Annotated[
        str | None,
        typer.Option(metavar="grammar|lm", help="Whole commands only, or the trigram model."),
    ] = None
    false_alarms: Annotated[
        float | None,
        typer.Option(
            "--false-alarms-per-hour",
            metavar="X",
            help="How many commands may be heard in an hour of talk; else 0.5, without network 20.",
        ),
    ] = None
    threshold: Annotated[
        float | None, typer.Option(metavar="X", help="Confidence that is needed, 0 to 1.")
    ] = None

    def settings(self, **others: Any) -> Config:
        """As for all, with how speech is recognized."""
        recognition = {
            "name": self.name,
            "search": self.search,
            "false_alarms_per_hour": self.false_alarms,
            "threshold": self.threshold,
        }
        return super().settings(recognition=recognition, **others)


def with_options(command: Callable[..., None]) -> Callable[..., None]:
    """Replace a subcommand's parameter `options` by the fields of its class, for typer."""
    # Not get_type_hints: in Python 3.10 it hides the names of an option whose default is None.
    hints = inspect.get_annotations(command, eval_str=True)
    kind = hints.pop("options")
    shared = get_type_hints(kind, include_extras=True)
    parameters = [
        parameter.replace(kind=parameter.KEYWORD_ONLY, annotation=hints[name])
        for name, parameter in inspect.signature(command).parameters.items()
        if name != "options"
    ] + [
        inspect.Parameter(
            field.name,
            inspect.Parameter.KEYWORD_ONLY,
            default=field.default,
            annotation=shared[field.name],
        )
        for field in _own_fields_first(kind)
    ]

    @functools.wraps(command)
    def call(**values: Any) -> None:
        options = kind(**{name: values.pop(name) for name in shared})
        check_memory(getattr(options, "least_memory", LEAST_MEMORY))
        command(options=options, **values)

    call.__signature__ = inspect.Signature(parameters)  # type: ignore[attr-defined]
    call.__annotations__ = hints | shared
    return call


def _own_fields_first(kind: type) -> list[Field[Any]]:
    """List the fields of a class, those that it adds before those that it inherits."""
    classes = [inspect.get_annotations(one) for one in kind.__mro__]
    return sorted(fields(kind), key=lambda field: [field.name in c for c in classes].index(True))


MAX_SUMMARY_LENGTH = 1000
"""Characters of the first sentence of a subcommand's help; typer would cut it at the line's end."""


class CommandGroup(TyperGroup):
    """Subcommands, each listed with its whole summary, on several lines if need be."""

    def format_commands(self, ctx: Any, formatter: Any) -> None:
        """Write the list of the subcommands."""
        commands = ((name, self.get_command(ctx, name)) for name in self.list_commands(ctx))
        with formatter.section("Commands"):
            formatter.write_dl(
                [
                    (name, command.get_short_help_str(MAX_SUMMARY_LENGTH))
                    for name, command in commands
                    if command and not command.hidden
                ]
            )
