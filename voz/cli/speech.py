"""`voz say`: speaks a text."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from voz.errors import SpeechError


def say(
    text: Annotated[str | None, typer.Argument(metavar="TEXT", help="What to say.")] = None,
    voice: Annotated[str, typer.Option(metavar="NAME", help="Who says it.")] = "kal_diphone",
    out: Annotated[
        Path | None, typer.Option(metavar="FILE.wav", help="Write it instead of playing it.")
    ] = None,
    list_voices: Annotated[
        bool, typer.Option("--list-voices", help="Show the voices that are installed.")
    ] = False,
) -> None:
    """Say a text with festival.

    Example: voz say "bep bep. I am listening you" --out hello.wav
    """
    from voz.speech import festival

    if list_voices:
        print("\n".join(festival.voices()))
    elif text is None:
        raise SpeechError("there is nothing to say; give a text in quotes, see --help")
    elif out:
        festival.render(text, voice, out)
    else:
        from voz.audio.playback import play

        play(festival.cached(text, voice))
