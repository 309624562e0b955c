"""`voz language`: languages other than English, which voz does not bring."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from voz.cli.help import CommandGroup
from voz.cli.text_io import show

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
    """Show the languages that were added."""
    from voz.language.spoken_language import added_languages

    show("English (comes with voz)", *added_languages())
