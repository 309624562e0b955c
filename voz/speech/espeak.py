"""Voices of espeak-ng, for the languages that festival has no voice for; a program it starts.

Its texts keep their letters, and come on its standard input. See
https://github.com/espeak-ng/espeak-ng
"""

from __future__ import annotations

import re
import shutil
from collections.abc import Sequence

from voz.errors import SpeechError

ESPEAK_PREFIX = "espeak-ng:"
"""Before the name of a voice, as in `espeak-ng:es`."""

_VOICE = re.compile(r"[A-Za-z0-9][A-Za-z0-9_-]{0,30}(\+[A-Za-z0-9_-]{1,20})?")


def is_espeak(voice: str) -> bool:
    """Tell whether a voice is one of espeak-ng's, by its name."""
    return voice.startswith(ESPEAK_PREFIX)


def check_espeak_voice(voice: str) -> None:
    """Raise SpeechError if a name cannot be that of a voice; only espeak-ng knows which it has."""
    if not _VOICE.fullmatch(voice.removeprefix(ESPEAK_PREFIX)):
        raise SpeechError(f"voice {voice!a} is unknown; see `espeak-ng --voices`")


def espeak_command(voice: str, wav: str) -> Sequence[str]:
    """What speaks the text on its standard input into a WAV file.

    Raises:
        SpeechError: espeak-ng is not installed.
    """
    path = shutil.which("espeak-ng")
    if path is None:
        raise SpeechError(
            "espeak-ng is not installed; install it with: sudo apt-get install espeak-ng"
        )
    return [path, "-v", voice.removeprefix(ESPEAK_PREFIX), "-w", wav, "--stdin"]


def no_voice_error(voice: str) -> SpeechError:
    """Say that there is no sound."""
    return SpeechError(f"voice {voice!a}: espeak-ng has no such voice; see `espeak-ng --voices`")
