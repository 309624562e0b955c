"""Whether the language files can be used, and by which ears. An edge: it reads them."""

from __future__ import annotations

from collections.abc import Iterator

from voz.apps.doctor.finding import Finding, not_well
from voz.config import Config
from voz.errors import VozError
from voz.language.generated.file_checks import check_files
from voz.language.generated.language_files import (
    LanguageFiles,
    find_language,
    read_sentences,
    stale_warning,
)
from voz.recognition.network_file import fingerprint_of
from voz.recognition.phoneme_scorer import why_missing
from voz.recognition.recognizer import Recognizer
from voz.settings import Recognition


def hearing(settings: Config) -> Iterator[Finding]:
    """Look at the language files, then at what is loaded from them."""
    try:
        files = find_language(settings.lm)
        check_files(files)
        yield _language(files)
        Recognizer(files, settings.recognition)
    except VozError as error:
        yield not_well("language files", error)
        return
    yield Finding("recognizer", True, "loads")
    yield second_ear(files, settings.recognition)


def second_ear(files: LanguageFiles, settings: Recognition) -> Finding:
    """Report whether there is a second ear; without one more that is no command is accepted."""
    name = "second ear"
    if not settings.second_ear:
        told = "off: [recognition] second_ear = false"
        return Finding(name, True, told, needed=False)
    if missing := why_missing(files, settings.network):
        to_do = "see [recognition] in docs/recognition.md; pocketsphinx decides alone until then"
        return Finding(name, False, f"none ({missing})", to_do, needed=False)
    network = fingerprint_of(settings.network)
    return Finding(name, True, f"hears phonemes (network {network})", needed=False)


def _language(files: LanguageFiles) -> Finding:
    name = "language files"
    if stale := stale_warning(files):
        told, _, to_do = stale.partition(": ")
        return Finding(name, False, told, to_do)
    folder = files.folder.resolve()
    return Finding(name, True, f"{folder}: whole, {len(read_sentences(files))} commands")
