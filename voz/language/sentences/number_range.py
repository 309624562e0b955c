"""Ranges of numbers in templates: limits, numbers and wordings; pure."""

from __future__ import annotations

from fractions import Fraction

from voz.language.sentences.expression import (
    Expression,
    NumberRange,
    Tag,
    choice,
    phrase,
    plain_number,
)
from voz.language.sentences.location import Location, error_at
from voz.language.sentences.number_words import wordings

MAX_RANGE_NUMBERS = 10_001


def check_range(numbers: NumberRange, place: Location) -> NumberRange:
    """Raise CommandsError if a range is empty, too long or has numbers that nobody says."""
    if numbers.step <= 0:
        raise error_at(place, "the step must be above 0")
    count = (numbers.last - numbers.first) // numbers.step + 1
    if count < 1:
        raise error_at(place, "empty range; write the smaller number first")
    if count > MAX_RANGE_NUMBERS:
        raise error_at(place, f"{count:,} numbers are too many; use a larger step")
    try:
        for number in numbers_in(numbers):
            wordings(number)
    except ValueError as error:
        raise error_at(place, f"{error}; use other numbers") from None
    return numbers


def numbers_in(numbers: NumberRange) -> list[Fraction]:
    """All numbers of a range."""
    count = (numbers.last - numbers.first) // numbers.step + 1
    return [numbers.first + n * numbers.step for n in range(count)]


def tagged_wordings(numbers: NumberRange) -> Expression:
    """Return all wordings of a range, tagged with their numbers; for two numbers, the smaller."""
    said: dict[str, Fraction] = {}
    for number in numbers_in(numbers):
        for text in wordings(number):
            said.setdefault(text, number)
    return choice([Tag(phrase(text), plain_number(number)) for text, number in said.items()])
