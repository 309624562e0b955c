"""The spoken language: English, or another one that the settings name. Does I/O.

Words of another one are pronounced by espeak-ng, or by an acoustic model and a dictionary of the
user: voz brings none, as each has a license of its own.
"""

from __future__ import annotations

import re
import shutil
import tempfile
from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import NamedTuple

import msgspec

from voz.errors import ConfigError, LanguageError
from voz.files import data_folder, sha256, shown_path
from voz.language.dictionaries import LetterRules, read_dictionary, read_rules
from voz.language.phones import PhoneDistances, known_phones, read_distances
from voz.settings import SpokenLanguage

ENGLISH_NAMES = frozenset({"english", "en"})

ENGLISH_MODEL = "en-us/en-us"
"""Path within the pocketsphinx package."""


LANGUAGES_FILE = Path(__file__).with_name("languages.tsv")
"""Code, name, and by whom voz was measured in it."""


class LanguageInfo(msgspec.Struct, frozen=True, dict=True):
    """A spoken language, as the language files keep it."""

    name: str  # what the user calls it
    # The folder of the model, relative to that of the language files or absolute; None is
    # pocketsphinx's English model.
    acoustic_model: str | None = None
    model: str = ""  # the SHA-256 of the model; empty for pocketsphinx's own
    # How many frames of 10 ms each phone lasts; of pocketsphinx's model it is known.
    frames: dict[str, float] = {}
    # What a frame of one phone loses, in nats, if it is taken for another; as before.
    apart: dict[str, dict[str, float]] = {}

    @property
    def is_english(self) -> bool:
        """Whether the accents and the phoneme network, which are English, can be used."""
        return self.name.lower() in ENGLISH_NAMES

    @property
    def code(self) -> str:
        """The language for other programs: `en`, else the name that the user gave, such as `es`."""
        return "en" if self.is_english else self.name

    @property
    def uses_default_model(self) -> bool:
        """Whether the model is pocketsphinx's own."""
        return self.acoustic_model is None

    @cached_property
    def phones(self) -> frozenset[str]:
        """The names of the phones."""
        return frozenset(self.distances.frames)

    @cached_property
    def distances(self) -> PhoneDistances:
        """How far apart the phones are."""
        return read_distances() if not self.frames else PhoneDistances(self.frames, self.apart)

    def folder(self, language: Path) -> Path:
        """Return the folder of the acoustic model; `language` is that of the language files."""
        if self.acoustic_model is None:
            import pocketsphinx  # takes 20 ms, which typed commands save

            return Path(pocketsphinx.get_model_path(ENGLISH_MODEL))
        return language / self.acoustic_model


def english() -> LanguageInfo:
    """Return English with pocketsphinx's model and the measured distances."""
    known = read_distances()
    apart = {phone: dict(others) for phone, others in known.apart.items()}
    return LanguageInfo("English", None, "", dict(known.frames), apart)


MODEL_FOLDER, DICTIONARY_FILE, RULES_FILE = "model", "dictionary.txt", "rules.txt"
"""Names of the parts in the folder of an added language."""

MODEL_FILES = ("mdef", "means", "variances", "transition_matrices", "feat.params")
WEIGHT_FILES = ("sendump", "mixture_weights")
"""Of which a model has one at least."""

_DICTIONARIES = ("*.dic", "*.dict", "*dictionary*.txt")


@dataclass(frozen=True)
class LanguageSources:
    """Where the parts of a language are."""

    name: str  # what the user calls it
    acoustic_model: Path  # the folder of the model
    dictionary: Path  # the pronunciations of its words
    rules: Path | None  # letter-to-sound rules for other words; None without


@dataclass(frozen=True)
class OtherLanguage:
    """A language that was read."""

    spoken: LanguageInfo  # its acoustic model and phones
    # The pronunciations of each word; None if espeak-ng knows them.
    dictionary: Mapping[str, tuple[str, ...]] | None = None
    rules: LetterRules | None = None  # letter-to-sound rules for other words; None without

    @property
    def phones(self) -> frozenset[str]:
        """The phones that a pronunciation may have."""
        return known_phones() if self.dictionary is None else self.spoken.phones


def is_english(settings: SpokenLanguage) -> bool:
    """Whether settings name English and no model of it."""
    named = settings.name.lower() in ENGLISH_NAMES
    return settings == SpokenLanguage() or (named and not _has_model(settings))


def _has_model(settings: SpokenLanguage) -> bool:
    """Whether settings name a model of a language, or a copy was added."""
    named = (settings.acoustic_model, settings.dictionary, settings.pronunciations)
    return named != (None, None, None) or _folder_of(settings.name).exists()


def find_sources(settings: SpokenLanguage) -> LanguageSources | None:
    """Find the model that the settings name, and the rest in the copy that was added.

    None if there is none, as for English, or a language that espeak-ng pronounces.

    Raises:
        ConfigError: something is missing.
    """
    if not _has_model(settings):
        return None
    copy = _folder_of(settings.name)
    model = _given(settings.acoustic_model, copy / MODEL_FOLDER, "acoustic_model", settings.name)
    dictionary = _given(settings.dictionary, copy / DICTIONARY_FILE, "dictionary", settings.name)
    rules = copy / RULES_FILE if settings.acoustic_model is None else None
    if settings.pronunciations is not None:
        rules = _given(settings.pronunciations, copy, "pronunciations", settings.name)
    return LanguageSources(
        settings.name, model, dictionary, rules if rules and rules.is_file() else None
    )


def configured_language(settings: SpokenLanguage) -> OtherLanguage | None:
    """Read the language that the settings name; None is English."""
    if is_english(settings):
        return None
    sources = find_sources(settings)
    return read_language(sources) if sources else OtherLanguage(LanguageInfo(settings.name))


def read_language(sources: LanguageSources) -> OtherLanguage:
    """Read a language; raises LanguageError if it cannot be used."""
    spoken = language_info(sources)
    dictionary = read_dictionary(sources.dictionary, spoken.phones)
    rules = read_rules(sources.rules, spoken.phones) if sources.rules else None
    return OtherLanguage(spoken, dictionary, rules)


def language_info(sources: LanguageSources) -> LanguageInfo:
    """Collect what language files keep of a language; raises LanguageError."""
    from voz.language.acoustic_model import compute_distances  # loads numpy, which English saves

    folder = sources.acoustic_model
    digest = model_digest(folder)
    found = compute_distances(folder)
    apart = {phone: dict(others) for phone, others in found.apart.items()}
    return LanguageInfo(sources.name, str(folder), digest, dict(found.frames), apart)


def model_digest(folder: Path) -> str:
    """The SHA-256 of an acoustic model; raises LanguageError if a file is missing."""
    from voz.language.acoustic_model import read_model_file  # as above

    weights = [name for name in WEIGHT_FILES if (folder / name).is_file()]
    total = sha256()
    for name in (*MODEL_FILES, *(weights or WEIGHT_FILES[:1])):
        total.update(read_model_file(folder, name))
    return total.hexdigest()


class KnownLanguage(NamedTuple):
    """A language whose phones voz knows."""

    code: str  # what `[language] name` is
    name: str  # in English
    measured: str  # on whose speech voz was measured in it


def known_languages() -> list[KnownLanguage]:
    """Read the languages whose phones voz knows."""
    lines = LANGUAGES_FILE.read_text(encoding="utf-8").splitlines()
    return [KnownLanguage(*line.split("\t")) for line in lines]


def add_language(folder: Path, name: str, dictionary: Path | None = None) -> LanguageSources:
    """Copy a language into the user's data folder, where settings find it by its name.

    Args:
        folder: holds an acoustic model and a dictionary, or subfolders with them.
        name: what to call it.
        dictionary: the dictionary, if there are several; rules are beside it, if there are any.

    Raises:
        LanguageError: it cannot be used or copied.
        ConfigError: the name is not usable as that of a folder.
    """
    target = _folder_of(name)  # checks the name before the work, which takes seconds
    words = dictionary or _only(_found(folder, _DICTIONARIES), folder, "dictionary")
    model = _only(_found(folder, ("mdef",)), folder, "mdef of an acoustic model").parent
    rules = words.with_name(RULES_FILE)
    source = LanguageSources(name, model, words, rules if rules.is_file() else None)
    read_language(source)
    try:
        target.parent.mkdir(parents=True, exist_ok=True)
        with tempfile.TemporaryDirectory(prefix=".voz-", dir=target.parent) as work:
            _copy(source, Path(work))
            shutil.rmtree(target, ignore_errors=True)
            shutil.move(Path(work) / name, target)
    except OSError as error:
        raise LanguageError(f"{target}: cannot be written ({error.strerror})") from None
    return LanguageSources(
        name,
        target / MODEL_FOLDER,
        target / DICTIONARY_FILE,
        target / RULES_FILE if source.rules else None,
    )


def added_languages() -> list[str]:
    """The names of the copies."""
    return sorted(path.parent.name for path in _folder_of("_").parent.glob(f"*/{DICTIONARY_FILE}"))


def _copy(source: LanguageSources, folder: Path) -> None:
    target = folder / source.name
    shutil.copytree(source.acoustic_model, target / MODEL_FOLDER, copy_function=shutil.copyfile)
    shutil.copyfile(source.dictionary, target / DICTIONARY_FILE)
    if source.rules:
        shutil.copyfile(source.rules, target / RULES_FILE)
    for path in (target, target / MODEL_FOLDER):
        path.chmod(0o755)  # the originals may be read-only


def _found(folder: Path, patterns: tuple[str, ...]) -> list[Path]:
    if not folder.is_dir():
        raise LanguageError(f"{shown_path(folder)}: not a folder; give that of a language")
    every = (path for pattern in patterns for path in folder.rglob(pattern) if path.is_file())
    return sorted({path for path in every if path.name != "noisedict"})


def _only(found: list[Path], folder: Path, what: str) -> Path:
    if len(found) == 1:
        return found[0]
    named = ", ".join(shown_path(path) for path in found[:4])
    raise LanguageError(
        f"{shown_path(folder)}: has several of what may be its {what} ({named}); name one"
        if found
        else f"{shown_path(folder)}: has no {what}; give a folder with CMUSphinx's files"
    )


def _given(named: str | None, copy: Path, setting: str, name: str) -> Path:
    path = copy if named is None else Path(named).expanduser()
    if path.exists():
        return path
    raise ConfigError(
        f'[language] "{name}": {shown_path(path)} is not there; set {setting}, '
        "or take a copy with `voz language add DIR`"
    )


def _folder_of(name: str) -> Path:
    if not re.fullmatch(r"\w[\w.-]{0,59}", name):
        raise ConfigError(f"{name!r} is not a valid name of a language; use letters and digits")
    return data_folder("languages") / name


def check_same_language(spoken: LanguageInfo, settings: SpokenLanguage, folder: Path) -> None:
    """Raise LanguageError for language files of another language than the settings name."""
    if is_english(settings):
        return
    sources = find_sources(settings)
    digest = model_digest(sources.acoustic_model) if sources else ""
    if (spoken.name, spoken.model) != (settings.name, digest):
        raise LanguageError(
            f"{shown_path(folder)}: made for {spoken.name}, and [language] says {settings.name}"
            + ("" if spoken.name != settings.name else " by another acoustic model")
            + "; make the language files again with `voz build-lm`"
        )


def check_acoustic_model(spoken: LanguageInfo, folder: Path) -> None:
    """Raise LanguageError if the acoustic model in `folder` is missing or was changed."""
    if spoken.uses_default_model:
        return
    model = spoken.folder(folder)
    if model_digest(model) != spoken.model:
        raise LanguageError(
            f"{model}: is another acoustic model than these language files were made for; "
            "make them again with `voz build-lm`"
        )
