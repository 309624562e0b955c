"""`voz commands`, `voz parse` and `voz language`: what may be said, and in which language."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from voz.cli.options import CommandGroup, CommonOptions, with_options
from voz.cli.text_io import info, show, show_raw, write_text
from voz.errors import LanguageError

CARD_FILE = Path("commands.html")


@with_options
def commands(
    options: CommonOptions,
    card: Annotated[
        bool, typer.Option("--card", help="Write a page to print, for a browser, A4.")
    ] = False,
    out: Annotated[
        Path, typer.Option(metavar="FILE.html", help="Where the page is written.")
    ] = CARD_FILE,
) -> None:
    """Show what may be said and what each command does, in a terminal or on a page to print.

    Example: voz commands --card --out card.html
    """
    from importlib.resources import files

    from voz.apps.command_card import card_lines, card_page, command_card, read_patterns
    from voz.files import shown_path
    from voz.language.language_files import list_sources, read_commands
    from voz.run.command_check import matched_settings

    settings = options.settings()
    language = options.language(settings)
    settings = matched_settings(settings, read_commands(language))
    sources = list_sources(language)
    if not sources:
        raise LanguageError(
            f"{language.folder}: does not tell from which list it was made; "
            "make the language files again with `voz build-lm`"
        )
    made = command_card(read_patterns(sources[0]), settings.table)
    if not card:
        show(*card_lines(made))
        return
    options.check_written(settings, [out], sources)
    icon = files("voz.apps.web").joinpath("page/icon.svg").read_text(encoding="utf-8")
    write_text(str(out), card_page(made, shown_path(Path(sources[0].name)), icon))
    info(f"written: {shown_path(out)}; open it in a browser and print it")


@with_options
def parse(
    options: CommonOptions,
    texts: Annotated[list[str], typer.Argument(metavar="TEXT...", help="What would be said.")],
    as_json: Annotated[bool, typer.Option("--json", help="One line of JSON for each.")] = False,
) -> None:
    """Show what sentences mean: their command and slots, or which command is nearest.

    Example: voz parse "go forward" "go forwards"
    """
    import msgspec

    from voz.language.language_files import read_commands
    from voz.texts import language_of, text

    settings = options.settings()
    commands = read_commands(options.language(settings))
    language = language_of(settings.language.name)
    for said in texts:
        found = commands.parse(said)
        meant = None if found else commands.closest_sentence(said)
        if as_json:
            fields = {
                "text": found.text if found else said,
                "command": found.command if found else None,
                "slots": dict(found.slots) if found else {},
            }
            show_raw(msgspec.json.encode(fields | ({"meant": meant} if meant else {})).decode())
        elif found:
            slots = "".join(f"  {name}={value}" for name, value in found.slots.items())
            show(f'"{found.text}": {found.command}{slots}')
        else:
            unknown = (
                '"{text}": no command; did you mean "{meant}"?' if meant else '"{text}": no command'
            )
            show(text(unknown, language, text=said, meant=meant))


languages = typer.Typer(
    cls=CommandGroup,
    rich_markup_mode=None,
    no_args_is_help=False,
    help="Take another language than English.",
)


@languages.command()
def add(
    folder: Annotated[
        Path, typer.Argument(metavar="DIR", help="An acoustic model and a dictionary of CMUSphinx.")
    ],
    name: Annotated[
        str | None, typer.Option(metavar="NAME", help="What to call it; else as the folder.")
    ] = None,
    dictionary: Annotated[
        Path | None, typer.Option(metavar="FILE", help="The dictionary, if there are several.")
    ] = None,
) -> None:
    """Check a language, copy it to your data folder and say what to write into voz.toml.

    Rules for words that the dictionary lacks may be beside it, in rules.txt.

    Example: voz language add cmusphinx-es-5.2 --name es
    """
    from voz.language.spoken_language import add_language

    added = add_language(folder, name or folder.resolve().name, dictionary)
    show(f"copied to {added.acoustic_model.parent}; in voz.toml:")
    show("", "[language]", f'name = "{added.name}"', "")
    show("Then `voz build-lm` makes the language files of a list in this language. Its replies are")
    show("said by another voice: see `voz say --list-voices`, and [speech] in voz.toml.")


@languages.command("list")
def list_added() -> None:
    """Show the languages that voz knows, by what they were measured, and those that you added."""
    from voz.language.spoken_language import added_languages, known_languages

    for known in known_languages():
        show(f"{known.code}  {known.name}: {known.measured}")
    show("any other that espeak-ng speaks (`espeak-ng --voices`): never measured")
    show(*(f"{name}: your copy, by pocketsphinx alone" for name in added_languages()))
