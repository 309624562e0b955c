"""`voz commands`: what may be said, and what it does."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from voz.cli.options import CommonOptions, with_options
from voz.cli.text_io import info, show, write_text
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

    from voz.apps.card.card_page import card_page
    from voz.apps.card.command_card import card_lines, command_card
    from voz.files import shown_path
    from voz.language.language_files import list_sources
    from voz.language.patterns import read_patterns

    settings = options.settings()
    language = options.language(settings)
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
