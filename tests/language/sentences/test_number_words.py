from __future__ import annotations

from fractions import Fraction

import pytest
from hypothesis import given
from hypothesis import strategies as st

from voz.language.sentences.number_words import wordings


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
