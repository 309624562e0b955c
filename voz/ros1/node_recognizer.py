"""The microphone, the recognizer and the language files of a node, by its parameters."""

from __future__ import annotations

import os
import tempfile
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

from voz.audio.loudspeaker import Mixer
from voz.audio.microphone import PULSE_DEVICE, SOURCE_VARIABLE
from voz.config import Config
from voz.errors import LanguageError
from voz.files import is_file
from voz.hearing.microphone_thread import Hearing, sound_card
from voz.inbox import Inbox
from voz.language.build import build
from voz.language.command_source import read_list
from voz.language.formats.command_list import parse_commands
from voz.language.grammar import jsgf
from voz.language.language_files import (
    LanguageFiles,
    check_model,
    check_words,
    find_language,
    parse_dictionary,
    parse_sentences,
    read_plain_text,
)
from voz.language.spoken_language import configured_language
from voz.recognition.engine import RecognitionEngine
from voz.recognition.profiles import load_profile
from voz.ros1.node import load_rospy, text_parameter
from voz.run.command_check import matched_settings
from voz.settings import SpokenLanguage

LMTOOL_HINT = (
    "name the files of one lmtool run, with the .sent or the .corpus beside the .lm, or give "
    "~commands instead"
)


def find_or_make_language(
    settings_lm: str | None, folder: Path, spoken: SpokenLanguage | None = None
) -> tuple[LanguageFiles, tuple[str, ...]]:
    """Find or make the language files by the node's parameters; return them with warnings.

    `settings_lm` and `spoken` are what voz.toml names; no language is English. New files go into an
    empty folder.
    """
    commands, lm, dictionary = (
        text_parameter("commands"),
        text_parameter("lm"),
        text_parameter("dict"),
    )
    if commands:
        given = read_list(Path(commands), configured_language(spoken) if spoken else None)
        return LanguageFiles(folder), build(Path(commands), folder, given).warnings
    if lm and dictionary:
        return import_lmtool_files(Path(lm), Path(dictionary), folder), ()
    if dictionary or (lm and Path(lm).is_file()):
        raise LanguageError("~lm and ~dict are both needed: set them, or ~commands alone")
    return find_language(lm or settings_lm, spoken), ()


def import_lmtool_files(lm: Path, dictionary: Path, folder: Path) -> LanguageFiles:
    """Convert a model and a dictionary of the online lmtool, which are in upper case.

    Beside the ARPA model is a `.sent` of the same name, with its sentences, or the `.corpus` that
    was given to lmtool. The folder gets the files, with voz's names.
    """
    files = LanguageFiles(folder)
    sent, corpus = lm.with_suffix(".sent"), lm.with_suffix(".corpus")
    if is_file(corpus) and not is_file(sent):
        sent, sentences = (
            corpus,
            list(parse_commands(_read(corpus).encode(), str(corpus)).sentences),
        )
    else:
        sentences = parse_sentences(_read(sent), sent, LMTOOL_HINT)
    words = parse_dictionary(_upper_phones(_read(dictionary)), dictionary, LMTOOL_HINT)
    model = _read(lm)
    check_words(sentences, words, sent, LMTOOL_HINT)
    check_model(model, words, lm, LMTOOL_HINT)
    _write(files.sentences, "".join(f"<s> {sentence} </s>\n" for sentence in sentences))
    _write(files.lm, model)
    _write(files.dictionary, "".join(f"{w}\t{' '.join(phones)}\n" for w, phones in words.items()))
    _write(files.grammar, jsgf(sentences))
    return files


def _read(path: Path) -> str:
    """Read a file of lmtool, whose words are in upper case."""
    return read_plain_text(path, LMTOOL_HINT).lower()


def _upper_phones(text: str) -> str:
    """Restore the upper case of a dictionary's phones, and drop empty lines."""
    words = (line.split(maxsplit=1) for line in text.splitlines() if line.strip())
    return "".join(f"{word}\t{' '.join(phones).upper()}\n" for word, *phones in words)


def _write(path: Path, text: str) -> None:
    path.write_text(text, encoding="utf-8")


def load_recognizer(settings: Config) -> tuple[Config, RecognitionEngine]:
    """Read the node's parameters and load the recognizer; settings get the list's names."""
    with tempfile.TemporaryDirectory(prefix="voz-lm-") as folder:
        language, warnings = find_or_make_language(settings.lm, Path(folder), settings.language)
        for warning in warnings:
            load_rospy().logwarn(warning)
        profile = text_parameter("profile")
        known = load_profile(profile, load_rospy().logwarn) if profile else None
        recognizer = RecognitionEngine(language, settings.recognition, known)
    return matched_settings(settings, recognizer.commands), recognizer


def make_hearing(
    recognizer: RecognitionEngine,
    settings: Config,
    inbox: Inbox,
    clock: Callable[[], float],
    loudspeaker: Mixer | None = None,
) -> Hearing:
    """Make what listens in a `with` block.

    The loudspeaker is one of this process, which the microphone hears too. Raises VozError.
    """
    playback = loudspeaker if settings.speech.half_duplex else None
    return Hearing(
        recognizer,
        replace(sound_card(_device()), playback=playback),
        inbox,
        clock,
        never_missed=settings.recognition.never_missed,
    )


def _device() -> str | None:
    """Return the microphone: `~device` as in `voz run`, or `~mic_name`, a PulseAudio source."""
    device, source = text_parameter("device"), text_parameter("mic_name")
    if device or not source:
        return device
    os.environ[SOURCE_VARIABLE] = source
    return PULSE_DEVICE
