"""What people read and hear in their language: a table for each one but English.

The keys of a table are the English texts, where `{name}` stands for what is inserted. What a table
lacks stays English. Events, logs and errors are English, too; what a person is shown of them is
translated there. Reads the tables, which come with voz.
"""

from __future__ import annotations

import re
import sys
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cache, reduce
from pathlib import Path

if sys.version_info >= (3, 11):
    import tomllib
else:
    import tomli as tomllib

ENGLISH = "en"

FOLDER = Path(__file__).parent

NOTICES = "notices"
"""The section of what events and errors say in English; a text of a run is searched there."""

TRANSLATED = ("what", "why")
"""What is inserted under these names is a text that is translated in turn, not a name."""

PLACEHOLDER = re.compile(r"\{(\w+)\}")


@dataclass(frozen=True)
class TextTable:
    """The texts of a language by the English ones; `notices` has those of the section."""

    texts: Mapping[str, str]
    notices: tuple[str, ...]


@cache
def languages() -> tuple[str, ...]:
    """The codes of all languages, English first."""
    return (ENGLISH, *sorted(path.stem for path in FOLDER.glob("*.toml")))


def language_of(name: str) -> str:
    """Return the code of a language such as `es-MX`; that of English if it has no table."""
    code = re.split("[-_]", name.lower())[0]
    return code if code in languages() else ENGLISH


@cache
def read_texts(language: str) -> TextTable:
    """Read the table of a language; that of English is empty."""
    if language == ENGLISH:
        return TextTable({}, ())
    sections = tomllib.loads((FOLDER / f"{language}.toml").read_text("utf-8"))
    texts = {english: own for section in sections.values() for english, own in section.items()}
    # The longer its own words, the less it is another text by chance.
    notices = sorted(sections[NOTICES], key=lambda key: -len(PLACEHOLDER.sub("", key)))
    return TextTable(texts, tuple(notices))


def text(english: str, language: str = ENGLISH, /, **values: object) -> str:
    """Return a text in a language, with values inserted."""
    return read_texts(language).texts.get(english, english).format(**values)


def list_texts(joined: str, texts: Sequence[str], language: str = ENGLISH) -> str:
    """Join texts in a language by one for two of them, such as "{one} or {other}"."""
    if not texts:
        return ""
    return reduce(lambda one, other: text(joined, language, one=one, other=other), texts)


def translate(said: str, language: str) -> str:
    """Translate what an event or an error says in English; what is unknown stays as it is."""
    for english in read_texts(language).notices:
        if found := _compiled(english).fullmatch(said):
            values = {
                name: translate(value, language) if name in TRANSLATED else value
                for name, value in found.groupdict().items()
            }
            return text(english, language, **values)
    return said


def pattern(english: str) -> str:
    """Return a regular expression for a text with whatever is inserted into it."""
    pieces = PLACEHOLDER.split(english)  # own words and names by turns
    return "".join(_piece(number, piece) for number, piece in enumerate(pieces))


@cache
def _compiled(english: str) -> re.Pattern[str]:
    return re.compile(pattern(english), re.DOTALL)


def _piece(number: int, piece: str) -> str:
    if number % 2 == 0:
        return re.escape(piece)
    # A name goes on to the end of its sentence: what follows may be translated, too.
    return f"(?P<{piece}>.+)" if piece in TRANSLATED else f"(?P<{piece}>(?:(?!; ).)+)"
