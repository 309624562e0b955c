"""Spelling: numbers as words, normalized words, typed text as it is spoken; pure."""

from __future__ import annotations

import re
import unicodedata
from collections.abc import Iterator
from fractions import Fraction
from functools import lru_cache

LARGEST_NUMBER = 999_999

_SAID = (
    "zero one two three four five six seven eight nine ten eleven twelve thirteen fourteen fifteen "
    "sixteen seventeen eighteen nineteen"
)
SMALL = _SAID.split()
DIGITS = SMALL[:10]

_TENS = "twenty thirty forty fifty sixty seventy eighty ninety"
TENS = _TENS.split()

QUARTERS = {
    Fraction(1, 4): ("a quarter", "one quarter"),
    Fraction(1, 2): ("a half", "half", "one half", "half a"),
    Fraction(3, 4): ("three quarters",),
}
"""Fractions that have names; `half a` as in `half a meter`."""


ENGLISH = "en"

OTHER_FORMS = {
    "de": (("^eins$", ("ein", "eine", "einen")), ("^ein(?=hundert|tausend)", ("",))),
    "es": (("iuno$", ("iún", "iuna")), (r"\buno$", ("un", "una")), (" punto ", (" coma ",))),
    "fr": ((r"\bun$", ("une",)),),
    "it": (("^uno$", ("un", "una")),),
    "pt": ((r"\bum$", ("uma",)), (r"\bdois$", ("duas",))),
}
"""What people say besides, by language: what is replaced, and by which texts."""


@lru_cache(maxsize=20_000)
def wordings(number: Fraction, language: str = ENGLISH) -> tuple[str, ...]:
    """Say a number in all usual ways, the plainest first: `one hundred and eighty`, `one eighty`.

    Args:
        number: at most six digits before the point and six after it.
        language: its code.

    Raises:
        ValueError: the number is too large, has more digits, or nobody knows the language.
    """
    if language != ENGLISH:
        return _in_language(number, language)
    if number < 0:
        return tuple(
            f"{sign} {text}" for sign in ("minus", "negative") for text in wordings(-number)
        )
    if number > LARGEST_NUMBER:
        raise ValueError(f"numbers go up to {LARGEST_NUMBER:,}")
    whole = number.numerator // number.denominator
    part = number - whole
    said = [*_whole(whole)] if not part else [*_decimal(whole, part), *_with_quarters(whole, part)]
    return tuple(dict.fromkeys(said))


def _in_language(number: Fraction, language: str) -> tuple[str, ...]:
    from num2words import num2words  # takes 30 ms, and English needs none

    wordings(abs(number))  # raises ValueError
    plain = int(number) if number.denominator == 1 else float(number)
    try:
        said = num2words(plain, lang=language.replace("-", "_"))
    except NotImplementedError:
        raise ValueError(f'voz knows no numbers of "{language}": write a list of them') from None
    found = [said.lower().replace("-", " ")]
    for pattern, texts in OTHER_FORMS.get(language.partition("-")[0], ()):
        found += [re.sub(pattern, text, found[0]) for text in texts]
    return tuple(dict.fromkeys(found))


def _whole(number: int) -> Iterator[str]:
    if number < 1000:
        yield from _below_a_thousand(number)
        return
    thousands, rest = divmod(number, 1000)
    heads = [f"{text} thousand" for text in _below_a_thousand(thousands)]
    heads += ["a thousand"] if thousands == 1 else []
    if not rest:
        yield from heads
    elif rest < 100:
        yield from (f"{head}{joint}{_small(rest)}" for joint in (" and ", " ") for head in heads)
    else:
        yield from (f"{head} {text}" for head in heads for text in _below_a_thousand(rest))
    if number < 10_000 and number % 100 == 0 and number % 1000:
        yield f"{_small(number // 100)} hundred"


def _below_a_thousand(number: int) -> Iterator[str]:
    hundreds, rest = divmod(number, 100)
    if not hundreds:
        yield _small(number)
        return
    heads = [f"{DIGITS[hundreds]} hundred", *(["a hundred"] if hundreds == 1 else [])]
    if not rest:
        yield from heads
        return
    yield from (f"{head}{joint}{_small(rest)}" for joint in (" and ", " ") for head in heads)
    if rest >= 10:
        yield f"{DIGITS[hundreds]} {_small(rest)}"


def _small(number: int) -> str:
    if number < 20:
        return SMALL[number]
    tens, ones = divmod(number, 10)
    return TENS[tens - 2] + (f" {DIGITS[ones]}" if ones else "")


def _decimal(whole: int, part: Fraction) -> Iterator[str]:
    after = " ".join(DIGITS[digit] for digit in _digits(part))
    yield from (f"{before} point {after}" for before in _whole(whole))
    if not whole:
        yield f"point {after}"


def _digits(part: Fraction) -> list[int]:
    digits: list[int] = []
    while part:
        if len(digits) == 6:
            raise ValueError("numbers have at most six digits after the point")
        digits.append(int(part * 10))
        part = part * 10 - digits[-1]
    return digits


def _with_quarters(whole: int, part: Fraction) -> Iterator[str]:
    for text in QUARTERS.get(part, ()):
        if not whole:
            yield text
        elif text.startswith(("a ", "three ", "one ")):
            yield from (f"{before} and {text}" for before in _whole(whole))


MAX_WORD_LETTERS = 40  # the longest English words have under 30; festival crashes on 3000

COMBINING_SIGN = r"(?:(?!\w)[\u0300-\u036f\u0900-\u0963\u0971-\u0d65])"
"""Vowel signs and accents that belong to a letter."""

ANY_LETTER = rf"(?:[^\W\d_]|{COMBINING_SIGN})"
"""A letter of any language."""

NOT_SPOKEN = ".,/;:!?…¿¡\"'‘’`´“”„«»()[]"  # noqa: RUF001 (what keyboards make of an apostrophe)
"""Marks between words, and apostrophes."""

SIGNS = {"%": "percent", "°": "degrees", "&": "and"}
"""Signs that are words."""


def normalize(text: str) -> str:
    """Convert to lower case with single spaces, and accented letters to one character each."""
    return " ".join(compose_accents(text.lower()).split())


def compose_accents(text: str) -> str:
    """Write each letter with its accent as one character."""
    return unicodedata.normalize("NFC", text)


def strip_accents(text: str) -> str:
    """Remove all accents, as typed on a keyboard without them."""
    letters = unicodedata.normalize("NFD", text)
    return "".join(letter for letter in letters if not unicodedata.combining(letter))


def find_unspeakable(text: str) -> tuple[int, str] | None:
    """Find the first character that nobody can say: its offset, and advice."""
    for at, char in enumerate(text):
        if not _can_be_spoken(char):
            return at, _advice(char)
    return None


def _can_be_spoken(char: str) -> bool:
    """Whether a character is spoken, or stands between words."""
    if char.isascii():
        return char.isalnum() or char in " \t\n-_" or char in NOT_SPOKEN or char in SIGNS
    kind = unicodedata.category(char)  # letters, signs put to them, white space, dashes
    return kind[0] in "LM" or kind in ("Zs", "Pd") or char in NOT_SPOKEN or char in SIGNS


def length_complaint(word: str) -> str:
    """Explain why a word is too long; empty if it is not."""
    if len(word) <= MAX_WORD_LETTERS:
        return ""
    return (
        f'"{word[:MAX_WORD_LETTERS]}..." has {len(word)} letters, '
        f"more than {MAX_WORD_LETTERS}; write it as several words"
    )


def _advice(char: str) -> str:
    shown = f'"{char}"' if char.isprintable() else f"the character U+{ord(char):04X}"
    if char.isnumeric():
        return f"{shown} is a digit; write the number as words, or as 0 to 9"
    return f"{shown} cannot be spoken; remove it"


_LETTERS = rf"(?:[^\W\d_]|{COMBINING_SIGN})+"
_TOKEN = re.compile(
    r"(?a:[0-9]+/[1-9][0-9]*|[-+]?[0-9]+(?:\.[0-9]+)?|\.[0-9]+)|" rf"{_LETTERS}(?:'{_LETTERS})*'?"
)
_PLAIN = str.maketrans(
    {**dict.fromkeys("‘’`´", "'"), **{sign: f" {word} " for sign, word in SIGNS.items()}}  # noqa: RUF001
)
"""Variants of an apostrophe, and signs that are words."""

_QUOTED = re.compile(r"(?<!\w)'([^']*)'(?!\w)")

_HYPHEN = re.compile(r"(?<=\w)-|-(?!\.?[0-9])")


def spoken_forms(text: str, language: str = ENGLISH) -> list[list[str]]:
    """Return the ways to say each word or number of typed text."""
    plain = _QUOTED.sub(r" \1 ", compose_accents(text.lower()).translate(_PLAIN))
    return [_said(token, language) for token in _TOKEN.findall(_HYPHEN.sub(" ", plain))]


def first_wording(text: str) -> str:
    """Return the plainest way to say a typed text; empty if it has no word."""
    return " ".join(ways[0] for ways in spoken_forms(text))


def plain_form(text: str) -> str:
    """Return text in its first wording and without accents: forms of one text are the same."""
    return strip_accents(first_wording(text))


def _said(token: str, language: str) -> list[str]:
    try:
        return list(wordings(Fraction(token), language))
    except ValueError:  # no number, or too large to be said
        return [token]
