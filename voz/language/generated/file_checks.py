"""Checks that language files are whole and belong together. Does I/O.

pocketsphinx crashes on a damaged model. `voz build-lm` leaves a fingerprint that shows any change;
files of lmtool or of an older voz have none, and are parsed strictly instead.
"""

from __future__ import annotations

import fcntl
import os
from collections.abc import Iterator, Mapping, Sequence
from contextlib import ExitStack, contextmanager, suppress
from pathlib import Path

from voz.checksum import sha256
from voz.errors import LanguageError
from voz.files import read_bytes, shown_path
from voz.language.generated.jsgf_grammar import jsgf
from voz.language.generated.language_files import (
    REBUILD_ADVICE,
    LanguageFiles,
    parse_sentences,
    read_plain_text,
    read_pronunciations,
)
from voz.language.generated.ngram import check_arpa


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
        sentences = parse_sentences(read_plain_text(files.sentences), files.sentences)
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
    return "".join(_line(name, text.encode()) for name, text in contents.items())


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
        if _line(path.name, read_bytes(path, LanguageError, REBUILD_ADVICE)) not in lines:
            raise LanguageError(f"{path}: was changed after `voz build-lm`; {REBUILD_ADVICE}")


def _line(name: str, data: bytes) -> str:
    return f"{sha256(data).hexdigest()}  {name}\n"
