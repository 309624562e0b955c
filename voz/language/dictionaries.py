"""Pronunciations of a language other than English, from a dictionary and letter-to-sound rules.

Only `read_dictionary` and `read_rules` do I/O.
"""

from __future__ import annotations

import re
import unicodedata
from collections.abc import Collection, Iterable, Mapping
from dataclasses import dataclass
from pathlib import Path

from voz.errors import CommandsError, LanguageError
from voz.files import read_text, shown_path
from voz.language.pronunciation import LexiconEntry
from voz.language.sentences.spelling import normalize
from voz.language.sentences.text_lines import PRONUNCIATIONS_FILE

DICTIONARY_ADVICE = "give a dictionary in CMUSphinx's format: a word and its phones a line"
RULES_ADVICE = "give rules: letters, a tab and their phones a line"

RULES_ORIGIN = "letter-to-sound rules"

MAX_DICTIONARY_BYTES = 100_000_000

_NAME = re.compile(r"(.+?)(\([0-9]{1,3}\))?")


@dataclass(frozen=True)
class LetterRules:
    """Letter-to-sound rules."""

    # Of each group of letters; silent letters have none. `^` before it stands for the beginning of
    # a word, `$` after it for the end.
    phones: Mapping[str, tuple[str, ...]]
    longest: int  # letters of the longest group, with such marks


def read_dictionary(path: Path, phones: Collection[str]) -> dict[str, tuple[str, ...]]:
    """Read a published dictionary, UTF-8, sorted or not; `##` and `;;;` begin comments.

    Returns:
        The pronunciations of each word in lower case, the usual one first.

    Raises:
        LanguageError: it cannot be read, or names an unknown phone.
    """
    text = read_text(path, LanguageError, DICTIONARY_ADVICE, MAX_DICTIONARY_BYTES)
    found: dict[str, dict[str, None]] = {}
    for number, line in enumerate(text.split("\n"), start=1):
        word, *said = line.split() or [""]
        if not word or word.startswith(("##", ";;;", "<")):
            continue
        strange = [phone for phone in said if phone not in phones]
        if strange or not said:
            what = f'the acoustic model has no phone "{strange[0]}"' if strange else "has no phones"
            raise LanguageError(f"{shown_path(path)}:{number}: {what}; {DICTIONARY_ADVICE}")
        match = _NAME.fullmatch(normalize(word))
        assert match  # it is not empty
        found.setdefault(match[1], {})[" ".join(said)] = None
    if not found:
        raise LanguageError(f"{shown_path(path)}: contains no word; {DICTIONARY_ADVICE}")
    return {word: tuple(ways) for word, ways in found.items()}


def read_rules(path: Path, phones: Collection[str]) -> LetterRules:
    """Read letter-to-sound rules: lines `letters<TAB>PHONE PHONE`; `#` begins a comment.

    Raises:
        LanguageError: a line is no rule, or names an unknown phone.
    """
    found: dict[str, tuple[str, ...]] = {}
    text = read_text(path, LanguageError, RULES_ADVICE, MAX_DICTIONARY_BYTES)
    for number, line in enumerate(text.split("\n"), start=1):
        letters, *said = line.partition("#")[0].split() or [""]
        where = f"{shown_path(path)}:{number}"
        if not letters:
            continue
        if not letters.removeprefix("^").removesuffix("$") or letters in found:
            raise LanguageError(f'{where}: "{letters}" is not a letter, or defined twice')
        if strange := [phone for phone in said if phone not in phones]:
            raise LanguageError(f'{where}: the acoustic model has no phone "{strange[0]}"')
        found[normalize(letters)] = tuple(said)
    if not found:
        raise LanguageError(f"{shown_path(path)}: contains no rule; {RULES_ADVICE}")
    return LetterRules(found, max(map(len, found)))


def apply_rules(word: str, rules: LetterRules) -> tuple[str, ...]:
    """Pronounce a word by the longest rule that fits at each place; no phones if none fits."""
    marked, at = f"^{word}$", 1
    said: list[str] = []
    while at < len(marked) - 1:
        rule = _longest_rule(marked, at, rules)
        if rule is None:
            return ()
        letters, begin = rule
        said += rules.phones[letters]
        at = begin + len(letters)
    return tuple(said)


def _longest_rule(marked: str, at: int, rules: LetterRules) -> tuple[str, int] | None:
    """Find the longest rule at a place; it may begin before it, at the `^`."""
    begins = (at - 1, at) if at == 1 else (at,)
    for length in range(rules.longest, 0, -1):
        for begin in begins:
            letters = marked[begin : begin + length]
            if len(letters) == length and letters in rules.phones and letters not in "^$":
                return letters, begin
    return None


def letters_of(words: Iterable[str]) -> frozenset[str]:
    """All letters of some words."""
    return frozenset(char for word in words for char in word if char.isalpha())


def pronounce_from(
    places: Mapping[str, str],
    user: Mapping[str, tuple[str, ...]],
    dictionary: Mapping[str, tuple[str, ...]],
    rules: LetterRules | None,
) -> dict[str, LexiconEntry]:
    """Find out how words are pronounced: by the user, a dictionary of `read_dictionary`, or rules.

    The first that knows a word decides. `places` has where each stands, as `FILE:LINE`; the entries
    are sorted by word. Raises CommandsError if a word has none.
    """
    entries: dict[str, LexiconEntry] = {}
    for word in places:
        if word in user:
            entries[word] = LexiconEntry(user[word], PRONUNCIATIONS_FILE)
        elif word in dictionary:
            entries[word] = LexiconEntry(dictionary[word], "dictionary")
        elif rules and (said := apply_rules(word, rules)):
            entries[word] = LexiconEntry((" ".join(said),), RULES_ORIGIN)
        else:
            raise _unknown(word, places[word], letters_of(dictionary), rules)
    return dict(sorted(entries.items()))


def _unknown(
    word: str, place: str, letters: Collection[str], rules: LetterRules | None
) -> CommandsError:
    strange = [c for c in word if c.isalpha() and c not in letters]
    if strange:
        name = unicodedata.name(strange[0], "unknown").lower()
        return CommandsError(
            f'{place}: "{word}" has the letter "{strange[0]}" ({name}), which no word of the '
            f"dictionary has; write another, or the word's phones in {PRONUNCIATIONS_FILE}"
        )
    also = ", and no rule fits its letters" if rules else ""
    return CommandsError(
        f'{place}: "{word}" is not in the dictionary{also}; write its phones in '
        f"{PRONUNCIATIONS_FILE} beside the list, or "
        "set `pronunciations` in [language] to a file of rules"
    )
