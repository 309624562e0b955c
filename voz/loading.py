"""A recogniser in one call, for programs of others."""

from __future__ import annotations

from pathlib import Path

from voz.language.files import find_language
from voz.recognition.recognizer import Recognizer
from voz.recognition.speaker.profiles import load_profile
from voz.records import check_is_a
from voz.settings import Recognition


def load(
    folder: str | Path | None = None,
    settings: Recognition | None = None,
    profile: str | None = None,
) -> Recognizer:
    """Load a recogniser; it takes a third of a second, and serves any number of recordings.

    Args:
        folder: the language files that `voz build-lm` made; None takes those in `lm/`, where there
            are any, or those that come with voz.
        settings: how sure it must be, and the like; None takes the usual ones.
        profile: the name of what `voz calibrate` knows of a speaker; None for nobody's.

    Raises:
        LanguageError: the language files cannot be used.
        ConfigError: there is no such profile, a model in the settings cannot be read, or an
            argument is something else.
    """
    known = None
    if profile is not None:
        check_is_a(str, profile, "profile")
        known = load_profile(profile)
    return Recognizer(find_language(folder), Recognition() if settings is None else settings, known)
