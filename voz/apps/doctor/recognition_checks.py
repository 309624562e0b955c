"""Whether the language files and the recognizer can be loaded. An edge: it reads them."""

from __future__ import annotations

from collections.abc import Iterator

from voz.apps.doctor.finding import Finding, failed
from voz.config import Config
from voz.errors import VozError
from voz.language.language_files import (
    LanguageFiles,
    check_files,
    find_language,
    read_sentences,
    stale_warning,
)
from voz.recognition.engine import RecognitionEngine
from voz.recognition.network.phoneme_network import fingerprint_of
from voz.recognition.network.score import why_missing
from voz.settings import Recognition

LANGUAGE_FILES = "language files"


def check_recognition(settings: Config) -> Iterator[Finding]:
    """Check the language files, then load the recognizer from them."""
    try:
        files = find_language(settings.lm)
        check_files(files)
        yield _check_language(files)
        RecognitionEngine(files, settings.recognition)
    except VozError as error:
        yield failed(LANGUAGE_FILES, error)
        return
    yield Finding("recognizer", True, "loads")
    yield check_network(files, settings.recognition)


def check_network(files: LanguageFiles, settings: Recognition) -> Finding:
    """Check the phoneme network; without it more is accepted that is no command."""
    name = "phoneme network"
    if not settings.use_network:
        return Finding(name, True, "off: [recognition] use_network = false", required=False)
    if missing := why_missing(files, settings.network):
        remedy = "see [recognition] in docs/recognition.md; pocketsphinx decides alone until then"
        return Finding(name, False, f"none ({missing})", remedy, required=False)
    network = fingerprint_of(settings.network)
    return Finding(name, True, f"hears phonemes (network {network})", required=False)


def _check_language(files: LanguageFiles) -> Finding:
    if stale := stale_warning(files):
        return Finding(LANGUAGE_FILES, False, stale, "`voz build-lm` builds the files again")
    folder = files.folder.resolve()
    return Finding(LANGUAGE_FILES, True, f"{folder}: whole, {len(read_sentences(files))} commands")
