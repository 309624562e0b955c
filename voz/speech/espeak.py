"""Voices of espeak-ng (https://github.com/espeak-ng/espeak-ng), for languages without festival."""

from __future__ import annotations

import re
import shutil
from collections.abc import Sequence

from voz.errors import SpeechError

ESPEAK_PREFIX = "espeak-ng:"
"""Of the names of its voices, as in `espeak-ng:es`."""

_VOICE = re.compile(r"[A-Za-z0-9][A-Za-z0-9_-]{0,30}(\+[A-Za-z0-9_-]{1,20})?")


def is_espeak(voice: str) -> bool:
    """Whether a voice is one of espeak-ng's, by its name."""
    return voice.startswith(ESPEAK_PREFIX)


def check_espeak_voice(voice: str) -> None:
    """Raise SpeechError for an impossible name; only espeak-ng knows which voices it has."""
    if not _VOICE.fullmatch(voice.removeprefix(ESPEAK_PREFIX)):
        raise SpeechError(f"voice {voice!a} is unknown; see `espeak-ng --voices`")


def espeak_command(voice: str, wav: str) -> Sequence[str]:
    """Return a command that speaks standard input into a file; SpeechError without espeak-ng."""
    path = shutil.which("espeak-ng")
    if path is None:
        raise SpeechError(
            "espeak-ng is not installed; install it with: sudo apt-get install espeak-ng"
        )
    return [path, "-v", voice.removeprefix(ESPEAK_PREFIX), "-w", wav, "--stdin"]


def no_voice_error(voice: str) -> SpeechError:
    """The error where espeak-ng wrote no sound."""
    return SpeechError(f"voice {voice!a}: espeak-ng has no such voice; see `espeak-ng --voices`")
