"""The language files: their names, where they are, readers, and checks. Does I/O.

pocketsphinx crashes on a damaged model. `voz build-lm` leaves a fingerprint that shows any change;
files of lmtool have none, and are parsed strictly instead.
"""

from __future__ import annotations

import fcntl
import os
import re
import shlex
from collections.abc import Collection, Iterator, Mapping, Sequence
from contextlib import ExitStack, contextmanager, suppress
from dataclasses import dataclass
from pathlib import Path

from voz.errors import CommandsError, LanguageError
from voz.files import is_file, read_bytes, read_json, sha256, shown_path
from voz.language.formats.command_list import parse_commands, read_file_or_names
from voz.language.grammar import jsgf
from voz.language.ngram import check_arpa
from voz.language.phones import PHONES, known_phones
from voz.language.sentences.command_set import (
    Commands,
    StoredCommands,
    decode_commands,
    plain_commands,
)
from voz.language.sentences.spelling import COMBINING_SIGN, ENGLISH, MAX_WORD_LETTERS
from voz.language.sentences.text_lines import MAX_TEXT_BYTES
from voz.language.spoken_language import LanguageInfo, english
from voz.language.word_neighbors import Rivals, decode_rivals
from voz.settings import SpokenLanguage

FILE_STEM = "comandos_voz"
PACKAGED_FOLDER = Path(__file__).parent.parent / "lm"
REBUILD_ADVICE = "make the language files again with `voz build-lm`"

_WORD = re.compile(
    rf"((?:[^\W_]|{COMBINING_SIGN}|['.-]){{1,{MAX_WORD_LETTERS}}})(\([0-9]{{1,3}}\))?"
)
"""Of a dictionary. Underscores are for voz's own words, other marks are JSGF syntax."""


class _File:
    """One of the language files, by its ending."""

    def __init__(self, ending: str) -> None:
        self._name = f"{FILE_STEM}.{ending}"

    def __get__(self, files: LanguageFiles, _: type[LanguageFiles]) -> Path:
        return files.folder / self._name


@dataclass(frozen=True)
class LanguageFiles:
    """The files of one language, all in one folder."""

    folder: Path

    commands = _File("txt")  # the command list
    dictionary = _File("dic")  # the pronunciations of all words, for the decoder
    lm = _File("lm")  # the trigram model, for the decoder
    grammar = _File("gram")  # the JSGF grammar, for the decoder
    sentences = _File("sent")  # the sentences that the files were generated from
    vocabulary = _File("vocab")  # the words of the sentences
    pronounce_log = _File("log_pronounce")  # where each pronunciation comes from
    templates = _File("templates")  # compiled templates; missing for a plain list
    spoken = _File("language")  # the spoken language; missing for English
    ipa = _File("ipa")  # pronunciations for the network; missing for English and other models
    source = _File("source")  # where a plain list is that is not beside the files; else missing
    rival_words = _File("rivals")  # what sounds much like the list's words
    fingerprint = _File("sha256")  # the SHA-256 of each that is generated, as `sha256sum` does

    @property
    def optional(self) -> tuple[Path, ...]:
        """All that is generated from some lists only."""
        return (self.templates, self.spoken, self.ipa, self.source, self.rival_words)

    @property
    def generated(self) -> tuple[Path, ...]:
        """All that is generated from the command list."""
        read = (self.dictionary, self.lm, self.grammar, self.sentences)
        others = [path for path in self.optional if path.exists()]
        return (*read, self.vocabulary, self.pronounce_log, *others)


def find_language(folder: str | Path | None, spoken: SpokenLanguage | None = None) -> LanguageFiles:
    """Find the language files: in `folder`, else in `lm/` here, else in the package.

    Of a language that voz has a list of, `lm/` counts only if it is in that language.

    Args:
        folder: None looks for them.
        spoken: the language that the settings name; None is English.

    Raises:
        LanguageError: the folder lacks a file that recognition needs.
    """
    here = LanguageFiles(Path("lm"))
    if folder is not None:
        files = LanguageFiles(Path(folder))
    else:
        files = packaged_files(spoken.name if spoken else "")
        is_other = files.spoken.is_file() and _language_name(here) != _language_name(files)
        if here.grammar.is_file() and not is_other:
            files = here
    for path in (files.dictionary, files.lm, files.grammar, files.sentences):
        if not is_file(path):
            raise LanguageError(
                f"{path}: is missing; make the language files with `voz build-lm LIST --out "
                f"{shlex.quote(shown_path(path.parent))}`"
            )
    return files


def _language_name(files: LanguageFiles) -> str:
    return read_language_info(files).name


def packaged_files(language: str) -> LanguageFiles:
    """The files that come with voz: in a language if there are any, else the English ones."""
    own = LanguageFiles(PACKAGED_FOLDER / language)
    return own if is_file(own.spoken) else LanguageFiles(PACKAGED_FOLDER)


def read_sentences(files: LanguageFiles) -> list[str]:
    """Read the sentences of the language files, in the order of the list; raises LanguageError."""
    return parse_sentences(read_plain_text(files.sentences), files.sentences)


def read_commands(files: LanguageFiles) -> Commands:
    """Read the commands of the language files; raises LanguageError."""
    stored = _stored(files)
    if stored:
        language = read_language_info(files).code if files.spoken.exists() else ENGLISH
        return decode_commands(stored, language)
    return plain_commands(read_sentences(files))


def _stored(files: LanguageFiles) -> StoredCommands | None:
    if not files.templates.exists():
        return None
    return read_json(files.templates, StoredCommands, LanguageError, REBUILD_ADVICE)


def list_name(files: LanguageFiles) -> str:
    """Return the name of the list that language files were made from; raises LanguageError."""
    sources = list_sources(files)
    return str(sources[0]) if sources else f"the list from which {files.folder} was made"


def list_sources(files: LanguageFiles) -> list[Path]:
    """Return the list that language files were made from, then what it imports, as far as known.

    Raises:
        LanguageError: the language files cannot be used.
    """
    if hashes := _source_hashes(files):
        return [Path(os.path.normpath(files.folder / name)) for name in hashes]
    return [files.commands] if files.commands.is_file() else []


def _source_hashes(files: LanguageFiles) -> dict[str, str]:
    """The SHA-256 of each file that was read, by its path from the folder; none if not kept."""
    if stored := _stored(files):
        return stored.sources
    if files.source.exists():
        return read_json(files.source, dict[str, str], LanguageError, REBUILD_ADVICE)
    return {}


def parse_sentences(text: str, path: Path, advice: str = REBUILD_ADVICE) -> list[str]:
    """Parse sentences; arguments and errors are those of `parse_dictionary`."""
    sentences = []
    for number, line in enumerate(_lines(text), start=1):
        words = line.split()
        if len(words) < 3 or (words[0], words[-1]) != ("<s>", "</s>"):
            raise LanguageError(f"{path}:{number}: expected `<s> sentence </s>`; {advice}")
        sentences.append(" ".join(words[1:-1]))
    if not sentences:
        raise LanguageError(f"{path}: is empty; {advice}")
    return sentences


def read_pronunciations(files: LanguageFiles) -> dict[str, tuple[str, ...]]:
    """The phones of each word; variants are words, as `the(2)`. Raises LanguageError."""
    phones = read_language_info(files).phones
    return parse_dictionary(read_plain_text(files.dictionary), files.dictionary, phones=phones)


def read_ipa(files: LanguageFiles) -> dict[str, tuple[str, ...]]:
    """The same by phones of another language, for the network; empty if there are none."""
    if not files.ipa.exists():
        return {}
    return parse_dictionary(read_plain_text(files.ipa), files.ipa, phones=known_phones())


def read_language_info(files: LanguageFiles) -> LanguageInfo:
    """Read which language is spoken; raises LanguageError."""
    if not files.spoken.exists():
        return english()
    return read_json(files.spoken, LanguageInfo, LanguageError, REBUILD_ADVICE)


def read_rival_words(files: LanguageFiles) -> Rivals:
    """Read what sounds much like the words of the list, if that is known; raises LanguageError."""
    if not files.rival_words.exists():
        return {}
    try:
        return decode_rivals(read_plain_text(files.rival_words))
    except ValueError as error:
        raise LanguageError(
            f"{files.rival_words}: cannot be used, {error}; {REBUILD_ADVICE}"
        ) from None


def parse_dictionary(
    text: str, path: Path, advice: str = REBUILD_ADVICE, phones: Collection[str] = PHONES
) -> dict[str, tuple[str, ...]]:
    """Parse a dictionary, as strictly as pocketsphinx needs it; raises LanguageError.

    The text is as `read_plain_text` has read it, the phones are those of the acoustic model.
    """
    words: dict[str, tuple[str, ...]] = {}
    for number, line in enumerate(_lines(text), start=1):
        word, *said = line.split() or [""]
        match = _WORD.fullmatch(word)
        if not match or not said or any(phone not in phones for phone in said):
            raise LanguageError(f"{path}:{number}: expected `word PHONE PHONE`; {advice}")
        if word in words or (match[2] and match[1] not in words):
            raise LanguageError(f"{path}:{number}: {word} is out of order; {advice}")
        words[word] = tuple(said)
    return words


def read_plain_text(path: Path, advice: str = REBUILD_ADVICE) -> str:
    """Read a text without control characters but tabs and line ends; raises LanguageError."""
    try:
        text = read_bytes(path, LanguageError, advice).decode()
    except UnicodeDecodeError:
        raise LanguageError(f"{path}: is not text; {advice}") from None
    text = text.replace("\r\n", "\n")
    if not text.replace("\n", "").replace("\t", "").isprintable():
        raise LanguageError(f"{path}: is not text; {advice}")
    return text


def _lines(text: str) -> list[str]:
    return text.removesuffix("\n").split("\n") if text else []


def stale_warning(files: LanguageFiles) -> str | None:
    """Warn if the command list has changed since its files were generated; else None."""
    if hashes := _source_hashes(files):
        changed = [name for name, known in hashes.items() if _sha(files, name) != known]
        path = Path(os.path.normpath(files.folder / changed[0])) if changed else None
        gone = path and files.source.exists() and not path.exists()  # the files came without it
        return _changed(path) if path and not gone else None
    if files.templates.exists() or not files.commands.is_file():
        return None
    try:
        data = read_bytes(files.commands, CommandsError, "", MAX_TEXT_BYTES)
        listed = set(parse_commands(data, str(files.commands)).sentences)
    except CommandsError:
        listed = set()  # it could be used when it was built, so it has changed
    if listed == set(read_sentences(files)):
        return None
    return _changed(files.commands)


def _changed(path: Path) -> str:
    return f"{path} has changed since the last `voz build-lm`: run it again"


def _sha(files: LanguageFiles, name: str) -> str | None:
    try:
        data = read_file_or_names(files.folder / name)
    except CommandsError:
        return None
    return sha256(data).hexdigest()


def check_files(files: LanguageFiles) -> None:
    """Raise LanguageError if files are missing or damaged, or do not belong together."""
    if shown_path(files.folder) != str(files.folder):
        raise LanguageError(
            f"{shown_path(files.folder)}: not a UTF-8 name, which pocketsphinx needs; "
            "rename the folder"
        )
    with lock_folder(files.folder, fcntl.LOCK_SH):
        if files.fingerprint.exists():
            _check_fingerprint(files)
            return
        if files.templates.exists():
            raise LanguageError(f"{files.fingerprint}: is missing; {REBUILD_ADVICE}")
        words = read_pronunciations(files)
        sentences = read_sentences(files)
        check_words(sentences, words, files.sentences)
        if read_plain_text(files.grammar) != jsgf(sentences):
            raise LanguageError(
                f"{files.grammar}: does not match {files.sentences}; {REBUILD_ADVICE}"
            )
        check_model(read_plain_text(files.lm), words, files.lm)


def check_words(
    sentences: Sequence[str], words: Mapping[str, object], path: Path, advice: str = REBUILD_ADVICE
) -> None:
    """Raise LanguageError if sentences, read from `path`, have a word that a dictionary lacks."""
    for word in dict.fromkeys(word for sentence in sentences for word in sentence.split()):
        if word not in words or "(" in word:
            raise LanguageError(f'{path}: "{word[:60]}" is not in the dictionary; {advice}')


def check_model(
    text: str, words: Mapping[str, object], path: Path, advice: str = REBUILD_ADVICE
) -> None:
    """Raise LanguageError if a trigram model, read from `path`, does not fit a dictionary."""
    try:
        check_arpa(text, words)
    except ValueError as error:
        raise LanguageError(f"{path}: cannot be used, {error}; {advice}") from None


def fingerprint(contents: Mapping[str, str]) -> str:
    """The SHA-256 of files by their names, in the format of `sha256sum`."""
    return "".join(_hash_line(name, text.encode()) for name, text in contents.items())


@contextmanager
def lock_folder(folder: Path, how: int) -> Iterator[None]:
    """Lock a folder against other processes of voz: `fcntl.LOCK_SH` or `LOCK_EX`."""
    with ExitStack() as opened:
        with suppress(OSError):  # some network drives have no locks; the fingerprint shows changes
            descriptor = os.open(folder, os.O_RDONLY)
            opened.callback(os.close, descriptor)
            fcntl.flock(descriptor, how)
        yield


def _check_fingerprint(files: LanguageFiles) -> None:
    lines = read_plain_text(files.fingerprint).splitlines(keepends=True)
    for path in files.generated:
        if _hash_line(path.name, read_bytes(path, LanguageError, REBUILD_ADVICE)) not in lines:
            raise LanguageError(f"{path}: was changed after `voz build-lm`; {REBUILD_ADVICE}")


def _hash_line(name: str, data: bytes) -> str:
    return f"{sha256(data).hexdigest()}  {name}\n"
