"""`voz sound`: plays a sound."""

from __future__ import annotations

import threading
from pathlib import Path
from typing import Annotated

import typer

from voz.cli.options import finite
from voz.cli.say_command import sound_client
from voz.cli.text_io import show
from voz.errors import AudioError


def sound(
    name: Annotated[
        str | None, typer.Argument(metavar="NAME|FILE", help="A built-in sound, or a file.")
    ] = None,
    repeat: Annotated[
        bool, typer.Option("--repeat", help="Play it again and again, until Ctrl-C.")
    ] = False,
    volume: Annotated[
        float, typer.Option(metavar="X", min=0.0, max=1.0, callback=finite, help="How loud.")
    ] = 1.0,
    list_sounds: Annotated[
        bool, typer.Option("--list", help="Show the names of the built-in sounds.")
    ] = False,
) -> None:
    """Play a built-in sound or a WAV, FLAC or OGG file.

    Example: voz sound backing-up --volume 0.5
    """
    from voz.speech.builtin_sounds import BuiltinSound

    builtin = {each.title: each for each in BuiltinSound}
    if list_sounds:
        show(*builtin)
        return
    if name is None:
        raise AudioError("there is nothing to play; give a file or a name from `voz sound --list`")
    if name not in builtin and not Path(name).exists():
        raise AudioError(f"{name}: is no file and no built-in sound; see `voz sound --list`")
    with sound_client(patient=repeat) as client:
        played = (
            client.builtin_sound(builtin[name], volume)
            if name in builtin
            else client.wave_sound(name, volume)
        )
        if repeat:
            played.repeat()
            threading.Event().wait()
        played.play(blocking=True)
