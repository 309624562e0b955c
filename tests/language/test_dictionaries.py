"""Pronunciations of another language: what its dictionary says, and what its rules do."""

from __future__ import annotations

from pathlib import Path

import pytest
from hypothesis import given
from hypothesis import strategies as st
from spanish import LIKE, RULES

from voz.errors import CommandsError, LanguageError
from voz.language.dictionaries import (
    apply_rules,
    pronounce_from,
    read_dictionary,
    read_rules,
)

READ = read_rules(RULES, LIKE)


@pytest.mark.parametrize(
    ("word", "phones"),
    [
        ("rota", "rr o t a"),
        ("para", "p a r a"),
        ("carro", "k a rr o"),
        ("honra", "o n rr a"),
        ("guitarra", "g i t a rr a"),
        ("pingüino", "p i n g u i n o"),
        ("queso", "k e s o"),
        ("cerveza", "z e r b e z a"),
        ("llave", "ll a b e"),
        ("señal", "s e gn a l"),
        ("hoy", "o i"),
        ("yo", "y o"),
        ("y", "i"),
        ("kö", ""),
    ],
)
def test_spanish_is_read_aloud_by_its_letters(word: str, phones: str) -> None:
    assert " ".join(apply_rules(word, READ)) == phones


@given(st.text())
def test_rules_give_phones_or_nothing_for_any_word(word: str) -> None:
    assert set(apply_rules(word, READ)) <= set(LIKE)


def test_a_dictionary_is_read_however_it_is_written(tmp_path: Path) -> None:
    path = tmp_path / "es.dic"
    path.write_text(";;; Spanish\nZeta\tz e t a\nel e l\nel(2)  e\ne\u0301l e l\r\n\n", "utf-8")
    assert read_dictionary(path, LIKE) == {"zeta": ("z e t a",), "el": ("e l", "e"), "él": ("e l",)}


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("el e l\nla L a\n", 'es.dic:2: the acoustic model has no phone "L"'),
        ("el\n", "es.dic:1: has no phones"),
        ("\n", "es.dic: contains no word"),
    ],
)
def test_a_dictionary_of_another_model_is_refused_with_its_line(
    text: str, message: str, tmp_path: Path
) -> None:
    (tmp_path / "es.dic").write_text(text)
    with pytest.raises(LanguageError) as caught:
        read_dictionary(tmp_path / "es.dic", LIKE)
    assert message in str(caught.value)


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("a\ta\na\te\n", 'rules.txt:2: "a" is not a letter, or defined twice'),
        ("^\ta\n", 'rules.txt:1: "^" is not a letter'),
        ("a\tAA\n", 'rules.txt:1: the acoustic model has no phone "AA"'),
        ("# nothing\n", "rules.txt: contains no rule"),
    ],
)
def test_wrong_rules_are_refused_with_their_line(text: str, message: str, tmp_path: Path) -> None:
    (tmp_path / "rules.txt").write_text(text)
    with pytest.raises(LanguageError) as caught:
        read_rules(tmp_path / "rules.txt", LIKE)
    assert message in str(caught.value)


def test_the_users_pronunciation_wins_then_the_dictionary_then_the_rules() -> None:
    places = dict.fromkeys(("rota", "gira", "más"), "mine.txt:1")
    dictionary = {"rota": ("r o t a",), "gira": ("j i r a",)}
    found = pronounce_from(places, {"rota": ("rr o t a",)}, dictionary, READ)
    assert {word: entry.phones for word, entry in found.items()} == {
        "gira": ("j i r a",),
        "más": ("m a s",),
        "rota": ("rr o t a",),
    }


@pytest.mark.parametrize(
    ("word", "message"),
    [
        ("gira", 'mine.txt:3: "gira" is not in the dictionary; write its phones in'),
        ("straße", 'mine.txt:3: "straße" has the letter "ß" (latin small letter sharp s)'),
    ],
)
def test_a_word_that_nothing_knows_is_refused_with_its_place(word: str, message: str) -> None:
    dictionary = {"girasat": ("a",), "re": ("a",)}
    with pytest.raises(CommandsError) as caught:
        pronounce_from({word: "mine.txt:3"}, {}, dictionary, None)
    assert message in str(caught.value)
