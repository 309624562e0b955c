"""The options of `voz build-lm`."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Annotated

import typer


@dataclass
class Building:
    """The options of `voz build-lm`."""

    out: Annotated[
        Path | None, typer.Option(metavar="DIR", help="Where to write; else beside the list.")
    ] = None
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
        bool, typer.Option("--alike", help="Also show the commands that sound most alike.")
    ] = False
    every_pair: Annotated[
        bool, typer.Option("--all", help="Show all pairs that sound alike, not ten lines of them.")
    ] = False
    picture: Annotated[
        Path | None,
        typer.Option(metavar="FILE.png|.svg", help="Also draw how alike all commands sound."),
    ] = None
