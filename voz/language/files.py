"""The language files: what they are called, where they are looked for. An edge: it reads them."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

from voz.errors import CommandsError, LanguageError
from voz.language.commands import parse_commands

STEM = "comandos_voz"
PACKAGED = Path(__file__).parent.parent / "lm"


@dataclass(frozen=True)
class LanguageFiles:
    """The files of one language, all in one folder.

    Attributes:
        folder: the folder, as the user or the search named it.
    """

    folder: Path

    @property
    def commands(self) -> Path:
        """The command list."""
        return self.folder / f"{STEM}.txt"

    @property
    def dictionary(self) -> Path:
        """The pronunciations of all words, for the decoder."""
        return self.folder / f"{STEM}.dic"

    @property
    def lm(self) -> Path:
        """The trigram model, for the decoder."""
        return self.folder / f"{STEM}.lm"

    @property
    def grammar(self) -> Path:
        """The JSGF grammar, for the decoder."""
        return self.folder / f"{STEM}.gram"

    @property
    def sentences(self) -> Path:
        """The sentences that the files were generated from."""
        return self.folder / f"{STEM}.sent"

    @property
    def vocabulary(self) -> Path:
        """The words of the sentences."""
        return self.folder / f"{STEM}.vocab"

    @property
    def pronounce_log(self) -> Path:
        """Where each pronunciation comes from."""
        return self.folder / f"{STEM}.log_pronounce"


def find_language(folder: str | Path | None) -> LanguageFiles:
    """Find the language files: in the folder given, else in `lm/` here, else in the package.

    Args:
        folder: where the user says that they are; None searches.

    Raises:
        LanguageError: the folder lacks a file that recognition needs.
    """
    here = LanguageFiles(Path("lm"))
    if folder is not None:
        files = LanguageFiles(Path(folder))
    elif here.grammar.is_file():
        files = here
    else:
        files = LanguageFiles(PACKAGED)
    for path in (files.dictionary, files.lm, files.grammar, files.sentences):
        if not path.is_file():
            raise LanguageError(f"{path}: is missing; make the language files with `voz build-lm`")
    return files


def read_sentences(files: LanguageFiles) -> list[str]:
    """Read the sentences that the language files were generated from, in the order of the list.

    Raises:
        LanguageError: the file cannot be read or holds something else.
    """
    path = files.sentences
    again = "make it again with `voz build-lm`"
    try:
        lines = path.read_text(encoding="utf-8").splitlines()
    except OSError as error:
        raise LanguageError(f"{path}: cannot be read ({error.strerror}); {again}") from None
    except UnicodeDecodeError:
        raise LanguageError(f"{path}: is not text; {again}") from None
    sentences = []
    for number, line in enumerate(lines, start=1):
        words = line.split()
        if len(words) < 3 or (words[0], words[-1]) != ("<s>", "</s>"):
            raise LanguageError(f"{path}:{number}: is no line `<s> sentence </s>`; {again}")
        sentences.append(" ".join(words[1:-1]))
    if not sentences:
        raise LanguageError(f"{path}: is empty; {again}")
    return sentences


def read_pronunciations(files: LanguageFiles) -> dict[str, tuple[str, ...]]:
    """Read the phones of each word of the dictionary; variants are words, as `the(2)`.

    Raises:
        LanguageError: the dictionary cannot be read.
    """
    try:
        lines = files.dictionary.read_text(encoding="utf-8").splitlines()
    except (OSError, UnicodeDecodeError) as error:
        raise LanguageError(
            f"{files.dictionary}: cannot be read; make it again with `voz build-lm`"
        ) from error
    return {word: tuple(phones) for word, *phones in map(str.split, lines) if phones}


def stale_warning(files: LanguageFiles) -> str | None:
    """Compare the command list with what the other files were generated from.

    Returns:
        A line that tells the user what to do, None if the list has the same sentences or there
        is no list in the folder.

    Raises:
        LanguageError: the sentences cannot be read.
    """
    try:
        data = files.commands.read_bytes()
    except OSError:
        return None
    try:
        listed = set(parse_commands(data, str(files.commands)).sentences)
    except CommandsError:
        listed = set()  # it could be used when it was built, so it has changed
    if listed == set(read_sentences(files)):
        return None
    return f"{files.commands} has changed since the last `voz build-lm`: run it again"
