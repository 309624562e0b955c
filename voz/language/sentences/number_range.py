"""Ranges of numbers in templates: their limits, their numbers and how these are said; pure."""

from __future__ import annotations

from fractions import Fraction

from voz.language.sentences.expression import Expression, Numbers, Tag, choice, phrase, tidy
from voz.language.sentences.location import Location, wrong
from voz.language.sentences.number_words import wordings

MOST_NUMBERS = 10_001
"""Numbers in one range."""


def checked(numbers: Numbers, place: Location) -> Numbers:
    """Check a range of numbers.

    Raises:
        CommandsError: it has none, or too many, or some that nobody says.
    """
    if numbers.step <= 0:
        raise wrong(place, "the numbers must grow; write a step above 0")
    count = (numbers.last - numbers.first) // numbers.step + 1
    if count < 1:
        raise wrong(place, "there is no number in this range; write the smaller one first")
    if count > MOST_NUMBERS:
        raise wrong(place, f"{count:,} numbers are too many; write a larger step")
    try:
        for number in values(numbers):
            wordings(number)
    except ValueError as error:
        raise wrong(place, f"{error}; write other numbers") from None
    return numbers


def values(numbers: Numbers) -> list[Fraction]:
    """All numbers of a range."""
    count = (numbers.last - numbers.first) // numbers.step + 1
    return [numbers.first + n * numbers.step for n in range(count)]


def in_words(numbers: Numbers) -> Expression:
    """All wordings of a range, each with its number; a wording of two has the smaller one's."""
    said: dict[str, Fraction] = {}
    for number in values(numbers):
        for text in wordings(number):
            said.setdefault(text, number)
    return choice([Tag(phrase(text), tidy(number)) for text, number in said.items()])
