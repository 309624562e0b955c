"""`voz build-lm`: from a list of commands to what the decoder reads."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from voz.cli.exit_codes import STALE
from voz.cli.terminal import show, tell, warn


def build_lm(
    commands: Annotated[Path, typer.Argument(metavar="[COMMANDS]", help="The command list.")] = (
        Path("lm/comandos_voz.txt")
    ),
    out: Annotated[
        Path | None, typer.Option(metavar="DIR", help="Where to write; else beside the list.")
    ] = None,
    check: Annotated[
        bool, typer.Option("--check", help="Write nothing; exit with 1 if files are stale.")
    ] = False,
    alike: Annotated[
        bool, typer.Option("--alike", help="Also show the commands that sound most alike.")
    ] = False,
    picture: Annotated[
        Path | None,
        typer.Option(metavar="FILE.png|.svg", help="Also draw how alike all commands sound."),
    ] = None,
) -> None:
    """Make the dictionary, language model and grammar from a list of commands.

    Warns of commands that sound alike.

    Example: voz build-lm lm/comandos_voz.txt
    """
    from voz.language import build
    from voz.language.alike import table

    if alike:
        show(*table(build.closest_commands(commands)).split("\n"))
    if picture:
        build.draw_alike(commands, picture)
    folder = out or commands.parent
    if check:
        if stale := build.check(commands, folder):
            names = ", ".join(stale)
            tell(f"{folder}: not what {commands} gives: {names}; run `voz build-lm`")
            raise typer.Exit(STALE)
        show(f"{folder}: up to date")
        return
    result = build.build(commands, folder)
    for warning in result.warnings:
        warn(warning)
    show(f"{result.sentences} sentences, {result.words} words:")
    show(*(f"  {path}" for path in result.paths))
