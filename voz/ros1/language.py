"""Which language files a node uses: its command list, its `~lm` and `~dict`, or voz's own."""

from __future__ import annotations

from pathlib import Path

from voz.errors import LanguageError
from voz.language.build import build
from voz.language.files import LanguageFiles, find_language, read_sentences
from voz.language.grammar import jsgf
from voz.ros1.parameters import text


def read_language(settings_lm: str | None, folder: Path) -> tuple[LanguageFiles, tuple[str, ...]]:
    """Find the language files by the node's parameters, or make them.

    Args:
        settings_lm: the folder that voz.toml names, if it does.
        folder: an empty folder for what is made.

    Returns:
        The files, and what there is to warn of.

    Raises:
        VozError: they cannot be used.
    """
    commands, lm, dictionary = text("commands"), text("lm"), text("dict")
    if commands:
        return LanguageFiles(folder), build(Path(commands), folder).warnings
    if lm and dictionary:
        return adopted(Path(lm), Path(dictionary), folder), ()
    if dictionary or (lm and Path(lm).is_file()):
        raise LanguageError("~lm and ~dict are both needed: set them, or ~commands alone")
    return find_language(lm or settings_lm), ()


def adopted(lm: Path, dictionary: Path, folder: Path) -> LanguageFiles:
    """Take over a model and a dictionary as the online lmtool made them, which writes upper case.

    Args:
        lm: the ARPA model; a `.sent` of the same name is beside it, with its sentences.
        dictionary: the pronunciations.
        folder: where the files are copied to, with the names that voz uses.

    Raises:
        LanguageError: one of them cannot be read.
    """
    files = LanguageFiles(folder)
    _write(files.sentences, _read(lm.with_suffix(".sent")).lower())
    _write(files.lm, _read(lm).lower())
    words = (line.split(maxsplit=1) for line in _read(dictionary).splitlines() if line.strip())
    _write(files.dictionary, "".join(f"{w.lower()}\t{' '.join(phones)}\n" for w, *phones in words))
    _write(files.grammar, jsgf(read_sentences(files)))
    return files


def _read(path: Path) -> str:
    try:
        return path.read_text(encoding="utf-8")
    except (OSError, UnicodeDecodeError) as error:
        raise LanguageError(
            f"{path}: cannot be read ({error}); name the files of one lmtool run, with the .sent "
            "beside the .lm, or give ~commands instead"
        ) from error


def _write(path: Path, text: str) -> None:
    path.write_text(text, encoding="utf-8")
