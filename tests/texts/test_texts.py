"""The tables of texts are complete, and what they say of a run is right."""

from __future__ import annotations

import ast
import re
import sys
from collections.abc import Iterator
from functools import cache

import pytest
from recordings import ROOT

from voz.apps.web.page_language import PAGE_FILES, SHOWN
from voz.config import default_commands
from voz.texts import (
    ENGLISH,
    PLACEHOLDER,
    language_of,
    languages,
    list_texts,
    read_texts,
    text,
    translate,
)

if sys.version_info >= (3, 11):
    import tomllib
else:
    import tomli as tomllib

OTHERS = [language for language in languages() if language != ENGLISH]

each_language = pytest.mark.parametrize("language", OTHERS)

WARNED_IN = ("apps/recordings", "apps/web", "control", "hearing", "robot", "run", "terminal")
"""Folders whose notices people see during a run."""

WARNS = ("Notice", "Halt", "StopMotion", "Health", "halt", "warn", "break")

LOST = ("trouble", "lost", "flood_report", "limit_reached")


def blank(english: str) -> str:
    """A text with all that is inserted left blank; a brace may be written twice."""
    return re.sub(r"\{+\w*\}+", "{}", english)


def template(part: ast.expr) -> str | None:
    """The text of an expression with all that is inserted left blank; None if it is none."""
    if isinstance(part, ast.Constant) and isinstance(part.value, str):
        return blank(part.value)
    if isinstance(part, ast.JoinedStr):
        pieces = (each.value if isinstance(each, ast.Constant) else "{}" for each in part.values)
        return blank("".join(map(str, pieces)))
    return None


@cache
def modules() -> dict[str, ast.Module]:
    paths = (ROOT / "voz").rglob("*.py")
    return {str(p.relative_to(ROOT / "voz")): ast.parse(p.read_text("utf-8")) for p in paths}


def in_code() -> Iterator[str]:
    """All texts of the program, the codes of reasons as words."""
    for module in modules().values():
        for part in ast.walk(module):
            if isinstance(part, ast.expr) and (found := template(part)):
                yield from (found, found.replace("_", " "))
    yield from default_commands().replies
    for path in PAGE_FILES.glob("*.js"):
        yield from map(blank, re.findall(r'"([^"]*)"', path.read_text("utf-8")))
    yield from map(blank, in_pages())


def in_pages() -> Iterator[str]:
    """The texts of the pages' HTML."""
    for path in PAGE_FILES.glob("*.html"):
        for found in SHOWN.finditer(path.read_text("utf-8")):
            yield " ".join((found[1] or found[2]).split())


def warned_of() -> Iterator[str]:
    """What people are warned of during a run, as far as it is written where it is given."""
    for path, module in modules().items():
        if path.startswith(WARNED_IN):
            constants = dict(_constants(module))
            for part in ast.walk(module):
                given = [constants.get(getattr(each, "id", ""), each) for each in _given(part)]
                yield from (said for each in given if (said := template(each)))


def _constants(module: ast.Module) -> Iterator[tuple[str, ast.expr]]:
    for part in module.body:
        if isinstance(part, ast.Assign) and isinstance(part.targets[0], ast.Name):
            yield part.targets[0].id, part.value


def _given(part: ast.AST) -> Iterator[ast.expr]:
    """What is given to whoever warns, or returned by what says why something is lost."""
    if isinstance(part, ast.Call):
        if getattr(part.func, "attr", getattr(part.func, "id", "")).strip("_") in WARNS:
            yield from part.args
    elif isinstance(part, ast.FunctionDef) and part.name.strip("_") in LOST:
        yield from (e.value for e in ast.walk(part) if isinstance(e, ast.Return) and e.value)


def test_there_are_spanish_and_french_beside_english() -> None:
    assert languages() == ("en", "es", "fr")


@each_language
def test_each_table_has_the_same_texts_with_the_same_inserted(language: str) -> None:
    own, spanish = (read_texts(each) for each in (language, "es"))
    assert own.texts.keys() == spanish.texts.keys()
    assert own.notices == spanish.notices
    for english, translated in own.texts.items():
        inserted = (sorted(PLACEHOLDER.findall(each)) for each in (english, translated))
        assert len(set(map(tuple, inserted))) == 1, english
        assert translated
        assert translated.strip() == translated or english.strip() != english


@each_language
def test_no_text_is_there_twice(language: str) -> None:
    path = ROOT / "voz" / "texts" / f"{language}.toml"
    sections = tomllib.loads(path.read_text("utf-8")).values()
    assert sum(map(len, sections)) == len(read_texts(language).texts) > 100


def test_each_text_of_a_table_is_one_of_the_program() -> None:
    known = set(in_code())
    spanish = read_texts("es")
    unused = [key for key in spanish.texts if blank(key) not in known]
    # A notice may be put together: "...: the robot stops".
    assert [
        key
        for key in unused
        if key not in spanish.notices or not any(blank(key) in each for each in known)
    ] == []


def words(said: str) -> list[str]:
    """What a text says between what is inserted, if that is more than a word or two."""
    return [piece for each in re.split(r"\{\}|[:;]", said) if len(piece := each.strip()) > 10]


def words_in(said: str, language: str) -> list[str]:
    """What is left of these in a translation."""
    translated = translate(said.replace("{}", "1"), language)
    return [piece for piece in words(said) if piece in translated]


@each_language
def test_each_notice_of_a_run_is_translated(language: str) -> None:
    told = {said for said in warned_of() if " " in said}
    assert len(told) > 20
    assert {
        said for said in told if not set(words(said)).isdisjoint(words_in(said, language))
    } == set()


def test_each_text_of_a_page_is_translated() -> None:
    known = read_texts("es").texts
    wordless = re.compile(r"voz|OK|m/s|rad/s|[\W\d½]*|[\d.]+ s")
    assert {
        each for each in in_pages() if each not in known and not wordless.fullmatch(each)
    } == set()
    shown = re.compile(
        r'\btext\(\s*"([^"]+)"|^  \w+: "([^"]+ [^"]+)",$|^  "\w+ \w+": "(.+)",$', re.M
    )
    for path in PAGE_FILES.glob("*.js"):
        found = ["".join(each) for each in shown.findall(path.read_text("utf-8"))]
        icons = path.name == "icons.js"
        assert icons or [each for each in found if each not in known] == [], path.name


def test_english_needs_no_table() -> None:
    assert text("not obeyed: {why}", why="{x}") == "not obeyed: {x}"
    assert translate("no command for 3 s: the robot stops", ENGLISH) == (
        "no command for 3 s: the robot stops"
    )


def test_what_a_table_lacks_is_english() -> None:
    assert text("a {thing} that no table knows", "es", thing="word") == "a word that no table knows"
    assert translate("a word that no table knows", "es") == "a word that no table knows"


@pytest.mark.parametrize(
    ("english", "spanish"),
    [
        ("no command for 3 s: the robot stops", "ninguna orden en 3 s: el robot se para"),
        (
            "the robot ros2 is lost (cannot keep up): the robot stops",
            "se ha perdido el robot ros2 (no da abasto): el robot se para",
        ),
        (
            'the commands were renewed: new "a", "b"; gone "c"',
            'órdenes renovadas: nuevas: "a", "b"; quitadas: "c"',
        ),
        ('no answer: "a wall" is not done', "sin respuesta: «a wall» no se hace"),
        ("a {brace} of nobody: the robot stops", "a {brace} of nobody: el robot se para"),
        ("three\nlines: the robot stops", "three\nlines: el robot se para"),
    ],
)
def test_what_a_run_says_is_translated_with_its_parts_but_not_its_names(
    english: str, spanish: str
) -> None:
    assert translate(english, "es") == spanish


def test_a_language_is_known_by_its_code() -> None:
    names = ("English", "en", "es", "ES", "es-MX", "fr_CA", "sv", "", "../es")
    assert [language_of(name) for name in names] == [
        *("en", "en", "es", "es", "es", "fr", "en", "en", "en")
    ]


def test_a_list_is_joined_in_its_language() -> None:
    assert list_texts("{one} or {other}", ["a", "b", "c"], "fr") == "a ou b ou c"
    assert list_texts("{one} or {other}", ["a"], "fr") == "a"
    assert list_texts("{one} or {other}", [], "fr") == ""
