"""`voz say`: speaks a text."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from shutil import which
from typing import TYPE_CHECKING, Annotated

import typer

from voz.cli.text_io import info, show, warn
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
        info(f"written: {out}, said by {voice}")
    else:
        with sound_client() as client:
            client.say(text, voice, blocking=True)


@contextmanager
def sound_client(patient: bool = False) -> Iterator[SoundClient]:
    """Yield a client; a missing loudspeaker is an error, unless `patient` waits for one."""
    from voz.process.standard_streams import quiet_libraries
    from voz.speech.sound_client import SoundClient

    problems: list[str] = []
    with quiet_libraries(), SoundClient(warn=warn if patient else problems.append) as client:
        yield client
    if problems:
        raise AudioError(problems[0])
