from __future__ import annotations

from fractions import Fraction

import pytest
from hypothesis import given
from hypothesis import strategies as st

from voz.language.sentences.spelling import wordings


@pytest.mark.parametrize(
    ("number", "said"),
    [
        ("0", {"zero"}),
        ("21", {"twenty one"}),
        ("100", {"one hundred", "a hundred"}),
        ("1500", {"one thousand five hundred", "a thousand five hundred", "fifteen hundred"}),
        ("-5", {"minus five", "negative five"}),
        ("2.5", {"two point five", "two and a half", "two and one half"}),
        ("0.75", {"zero point seven five", "point seven five", "three quarters"}),
    ],
)
def test_wordings(number: str, said: set[str]) -> None:
    assert set(wordings(Fraction(number))) == said


def test_what_nobody_says_is_refused() -> None:
    for number in (Fraction(1, 3), Fraction(10**6)):
        with pytest.raises(ValueError, match="numbers"):
            wordings(number)


@given(st.integers(0, 999_999), st.integers(0, 999_999))
def test_two_whole_numbers_never_sound_the_same(one: int, other: int) -> None:
    shared = set(wordings(Fraction(one))) & set(wordings(Fraction(other)))
    assert not shared or one == other


@pytest.mark.parametrize(
    ("language", "number", "said"),
    [
        ("es", "21", {"veintiuno", "veintiún", "veintiuna"}),
        ("es", "31", {"treinta y uno", "treinta y un", "treinta y una"}),
        ("es", "180", {"ciento ochenta"}),
        ("es-419", "2.5", {"dos punto cinco", "dos coma cinco"}),
        ("fr", "91", {"quatre vingt onze"}),
        ("fr", "21", {"vingt et un", "vingt et une"}),
        ("fr", "-5", {"moins cinq"}),
        ("it", "80", {"ottanta"}),
        ("it", "1", {"uno", "un", "una"}),
        ("de", "121", {"einhunderteinundzwanzig", "hunderteinundzwanzig"}),
        ("de", "1", {"eins", "ein", "eine", "einen"}),
        ("pt", "22", {"vinte e dois", "vinte e duas"}),
        ("pt-br", "0.5", {"zero vírgula cinco"}),
    ],
)
def test_wordings_in_other_languages(language: str, number: str, said: set[str]) -> None:
    assert set(wordings(Fraction(number), language)) == said


@pytest.mark.parametrize("number", ["1000000", "1/3"])
def test_what_nobody_says_in_english_nobody_says_elsewhere(number: str) -> None:
    with pytest.raises(ValueError, match="numbers"):
        wordings(Fraction(number), "es")


def test_a_language_whose_numbers_nobody_knows_is_named() -> None:
    with pytest.raises(ValueError, match='no numbers of "xx": write a list'):
        wordings(Fraction(3), "xx")
