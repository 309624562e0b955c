"""`voz say` and `voz sound`: speak a text, play a sound."""

from __future__ import annotations

import threading
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from shutil import which
from typing import TYPE_CHECKING, Annotated

import typer

from voz.cli.options import finite
from voz.cli.terminal import show, tell, warn
from voz.errors import AudioError, SpeechError

if TYPE_CHECKING:
    from voz.speech.sound_client import SoundClient


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
    """Say a text with festival, or by a voice of espeak-ng, as espeak-ng:es.

    Example: voz say "bep bep. I am listening you" --out hello.wav
    """
    from voz.speech import festival

    if list_voices:
        show(*festival.installed_voices())
        if which("espeak-ng"):
            show("espeak-ng:en, espeak-ng:es, ... (see `espeak-ng --voices`)")
    elif text is None:
        raise SpeechError("there is nothing to say; give a text in quotes, see --help")
    elif out:
        festival.render(text, voice, out)
        tell(f"written: {out}, said by {voice}")
    else:
        with _sounding() as client:
            client.say(text, voice, blocking=True)


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
    with _sounding(patient=repeat) as client:
        played = (
            client.builtin_sound(builtin[name], volume)
            if name in builtin
            else client.wave_sound(name, volume)
        )
        if repeat:
            played.repeat()
            threading.Event().wait()
        played.play(blocking=True)


@contextmanager
def _sounding(patient: bool = False) -> Iterator[SoundClient]:
    """Give a client. If there is no loudspeaker that is an error, unless one is waited for."""
    from voz.process.standard_streams import quiet_libraries
    from voz.speech.sound_client import SoundClient

    problems: list[str] = []
    with quiet_libraries(), SoundClient(warn=warn if patient else problems.append) as client:
        yield client
    if problems:
        raise AudioError(problems[0])
