"""English pronunciations: the user's, the CMU dictionary's, of compounds, festival's guesses."""

from __future__ import annotations

import re
import subprocess
from bisect import bisect_left
from collections.abc import Callable, Collection, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from itertools import combinations, pairwise, product
from pathlib import Path

from voz.errors import CommandsError
from voz.language.phones import PHONE_NAMES, PHONES
from voz.language.sentences.spelling import ANY_LETTER, normalize
from voz.language.sentences.text_lines import PRONUNCIATIONS_FILE, content_lines

# festival's time for a word grows with the words before it (400 take 2 s, 1600 more than 40 s),
# so a long list is given to several processes, one after the other.
WORDS_PER_PROCESS = 200
FESTIVAL_TIME_LIMIT = 60.0  # s for one process, which takes under one second on an idle desktop

# Festival's US phones ("radio") that the acoustic model calls otherwise; the rest are the same
# in upper case. None is silence.
FESTIVAL_PHONES = {
    "ax": "AH", "axr": "ER", "dx": "T", "el": "AH L", "em": "AH M", "en": "AH N",
    "hv": "HH", "nx": "N", "pau": None, "brth": None,
}  # fmt: skip
_ANSWER = re.compile(r'^\("([a-z]+)" ')
_SYLLABLE = re.compile(r"\(([a-z ]+)\) [0-9]\)")


class FestivalError(Exception):
    """festival cannot guess; the message says why and what to do."""


def guess(words: Sequence[str]) -> dict[str, str]:
    """Guess the phones of each word of the letters a to z, such as "Z AO R B L AE K S".

    Words that festival cannot pronounce are missing. Raises FestivalError.
    """
    spellings = {word: word.replace("'", "") for word in words}
    letters = sorted({spelling for spelling in spellings.values() if spelling})
    guesses: dict[str, str] = {}
    for start in range(0, len(letters), WORDS_PER_PROCESS):
        answer = run_festival(_program(letters[start : start + WORDS_PER_PROCESS]))
        guesses.update(_read_answer(answer))
    return {word: guesses[spelling] for word, spelling in spellings.items() if spelling in guesses}


def _program(words: Iterable[str]) -> str:
    lines = ["(setup_cmu_lex)"]  # whatever voice the user's .festivalrc selects
    for word in words:
        if not re.fullmatch("[a-z]+", word):  # anything else could be Scheme
            raise ValueError(f"not a plain word: {word!r}")
        lines.append(f'(print (lex.lookup "{word}" nil))')
    return "\n".join(lines) + "\n"


def run_festival(program: str) -> str:
    """Return what festival prints for a program in Scheme; raises FestivalError."""
    try:
        done = subprocess.run(
            ["festival", "--pipe"],
            input=program,
            capture_output=True,
            encoding="latin-1",  # decodes whatever comes
            timeout=FESTIVAL_TIME_LIMIT,
            check=True,
        )
    except FileNotFoundError:
        raise FestivalError(
            "festival is not installed; install it (apt-get install festival festlex-cmu)"
        ) from None
    except subprocess.TimeoutExpired:
        raise FestivalError(
            f"festival did not answer within {FESTIVAL_TIME_LIMIT:.0f} s; try again"
        ) from None
    except (OSError, subprocess.CalledProcessError) as error:
        raise FestivalError(f"festival failed ({error}); reinstall it") from None
    return done.stdout


def _read_answer(answer: str) -> dict[str, str]:
    """Read lines such as `("zorblax" nil (((z ao r) 1) ((b l ae k s) 1)))`."""
    guesses = {}
    for line in answer.splitlines():
        match = _ANSWER.match(line)
        phones = [phone for group in _SYLLABLE.findall(line) for phone in group.split()]
        known = [FESTIVAL_PHONES.get(phone, phone.upper()) for phone in phones]
        spoken = " ".join(phone for phone in known if phone)
        if match and spoken:
            guesses[match.group(1)] = spoken
    return guesses


GUESS_ORIGIN = "letter-to-sound (a guess)"
SPELLED_ORIGIN = "letter by letter (a guess)"
MIN_PART_LETTERS = 3  # letters of the shortest part of a compound
MAX_COMPOUND_PARTS = 3

BOTH_ORIGIN = "letter-to-sound, or letter by letter (a guess)"
GUESSES = frozenset({GUESS_ORIGIN, SPELLED_ORIGIN, BOTH_ORIGIN})

MAX_SPELLED_LETTERS = 5
SURELY_SPELLED_LETTERS = 3
"""Capitals of so few letters are rather spelled: IMU, PIR, API; LIDAR and YAML are words."""

_ACRONYM = re.compile("[b-df-hj-np-tv-xz]{2,5}|[b-df-hj-np-tv-z]{2,3}")
"""A word that can only be spelled, as it has no vowel: `mqtt`, `kg`, `xyz`."""

_ENGLISH_BEGINNING = re.compile(
    "([a-z]|[bcfgkps][lr]|[dpt]r|[cgpstw]h|[dst]w|s[ckmnpqt]|s[ckpt]r|sch|shr|spl|thr|kn|qu|ts|wr)?"
    "[aeiouy]"
)
"""Up to its first vowel; GPIO, RFID and HDMI have none of these and are spelled."""

_USER_WORD = re.compile(rf"((?:{ANY_LETTER}|')+)(\([0-9]+\))?")
_ENGLISH_WORD = re.compile(r"([a-z']+)(\([0-9]+\))?", re.ASCII)
_NOT_ENGLISH = re.compile(r"[^a-z']")

Guesser = Callable[[Sequence[str]], dict[str, str]]


@dataclass(frozen=True)
class LexiconEntry:
    """How a word is pronounced."""

    phones: tuple[str, ...]  # its pronunciations, the usual one first, each such as "K OW L AH"
    origin: str  # where they come from, for people to read
    # Those of another language, for the network; `phones` are the nearest English ones.
    ipa: tuple[str, ...] = ()


def dictionary_entries(entries: Mapping[str, LexiconEntry]) -> Iterator[tuple[str, str]]:
    """Yield the words with their phones; a further pronunciation is a variant, as `the(2)`."""
    yield from _numbered({word: entry.phones for word, entry in entries.items()})


def ipa_entries(entries: Mapping[str, LexiconEntry]) -> Iterator[tuple[str, str]]:
    """The same for the phones of another language."""
    yield from _numbered({word: entry.ipa for word, entry in entries.items()})


def _numbered(ways: Mapping[str, tuple[str, ...]]) -> Iterator[tuple[str, str]]:
    for word, each in ways.items():
        for number, phones in enumerate(each, start=1):
            yield word if number == 1 else f"{word}({number})", phones


def read_cmudict() -> bytes:
    """Read the CMU dictionary of the pocketsphinx package, sorted by word, as bytes.

    To parse its 135,000 lines would take longer than the rest of a build.
    """
    import pocketsphinx  # takes 20 ms, which typed commands save

    return Path(pocketsphinx.get_model_path("en-us/cmudict-en-us.dict")).read_bytes()


def look_up(cmudict: bytes, word: str) -> tuple[str, ...]:
    """Look a lower-case word up in a sorted dictionary by bisection; it may have none."""
    offsets = range(len(cmudict))
    start = bisect_left(offsets, word.encode(), key=lambda offset: _word_at(cmudict, offset))
    return _pronunciations_at(cmudict, start, word)


def find_anywhere(cmudict: bytes, word: str) -> tuple[str, ...]:
    """Look a word up linearly, 2 ms: pocketsphinx 5.0 has `stilton` and others out of order."""
    return _pronunciations_at(cmudict, cmudict.find(f"\n{word} ".encode()) + 1, word)


def _word_at(cmudict: bytes, offset: int) -> bytes:
    start = cmudict.rfind(b"\n", 0, offset) + 1
    return cmudict[start : cmudict.find(b" ", start)].partition(b"(")[0]


def _pronunciations_at(cmudict: bytes, start: int, word: str) -> tuple[str, ...]:
    found = []
    while start < len(cmudict) and _word_at(cmudict, start) == word.encode():
        end = cmudict.find(b"\n", start)
        found.append(cmudict[start:end].partition(b" ")[2].decode())
        start = end + 1
    return tuple(found)


def parse_pronunciations(
    data: bytes, name: str, phones_known: Collection[str] | None = None
) -> dict[str, tuple[str, ...]]:
    """Parse the user's pronunciations, UTF-8: lines `word PH PH`, `#` begins a comment.

    A word may have several. The phones are those of another language's acoustic model; None is
    English.
    """
    found: dict[str, dict[str, None]] = {}
    for number, text in content_lines(data, name):
        where = f"{name}:{number}"
        word, *phones = text.split()
        pattern = _ENGLISH_WORD if phones_known is None else _USER_WORD
        match = pattern.fullmatch(normalize(word))
        if not match:
            raise CommandsError(
                f"{where}: {word!a} is not a word of the letters a to z; write a word, "
                "then its phones, as in: cocacola K OW K AH K OW L AH"
            )
        found.setdefault(match.group(1), {})[_check_phones(phones, where, phones_known)] = None
    return {word: tuple(phones) for word, phones in found.items()}


def _check_phones(phones: Sequence[str], where: str, known: Collection[str] | None) -> str:
    """Normalize phones; for English to upper case, without stress digits."""
    plain = list(phones) if known else [phone.upper().rstrip("012") for phone in phones]
    if not plain:
        raise CommandsError(f"{where}: no phones after the word")
    for given, phone in zip(phones, plain, strict=True):
        if phone not in (known or PHONES):
            names = " ".join(sorted(known)) if known else PHONE_NAMES
            raise CommandsError(f"{where}: {given!a} is not a phone; the phones are {names}")
    return " ".join(plain)


def check_english(places: Mapping[str, str]) -> None:
    """Raise CommandsError for a word with letters that English does not have."""
    for word, place in places.items():
        if wrong := _NOT_ENGLISH.search(word):
            raise CommandsError(
                f'{place}: "{wrong.group()}" is not one of the letters a to z; write the word with '
                "plain letters and its pronunciation in pronunciations.txt, or set [language]"
            )


def pronounce(
    places: Mapping[str, str],
    user: Mapping[str, tuple[str, ...]],
    cmudict: bytes,
    guess: Guesser,
    capitals: Collection[str] = (),
) -> dict[str, LexiconEntry]:
    """Find out how words are pronounced: by the user, CMUdict, spelling capitals, or a guess.

    The first that knows a word decides. `places` has where each stands, as `FILE:LINE`; the entries
    are sorted by word. Raises CommandsError if a word has none.
    """

    def known(word: str) -> tuple[str, ...]:
        return user.get(word) or look_up(cmudict, word)

    def spelled(word: str) -> tuple[str, ...]:
        return _join(word, lambda letter: ("EY",) if letter == "a" else known(letter))

    entries: dict[str, LexiconEntry] = {}
    for word in places:
        if word in user:
            entries[word] = LexiconEntry(user[word], PRONUNCIATIONS_FILE)
        elif phones := look_up(cmudict, word) or find_anywhere(cmudict, word):
            entries[word] = LexiconEntry(phones, "cmudict")
        elif parts := split_compound(word, known):
            entries[word] = LexiconEntry(_join(parts, known), f"compound {'+'.join(parts)}")
        elif _ACRONYM.fullmatch(word) or (word in capitals and not _ENGLISH_BEGINNING.match(word)):
            entries[word] = LexiconEntry(spelled(word), SPELLED_ORIGIN)
    unknown = [word for word in places if word not in entries]
    entries.update(_guess_all(unknown, places, guess))
    for word in set(capitals).intersection(unknown):
        both = (*entries[word].phones, *spelled(word))
        ways = both[::-1] if len(word) <= SURELY_SPELLED_LETTERS else both
        entries[word] = LexiconEntry(tuple(dict.fromkeys(ways)), BOTH_ORIGIN)
    return dict(sorted(entries.items()))


_WRITTEN_WORD = re.compile(r"[^\W\d_]+")


def words_in_capitals(texts: Iterable[str]) -> set[str]:
    """Find the short words that are always in capitals, where not all is; in lower case."""
    capitals, others = set[str](), set[str]()
    for text in texts:
        words = set(_WRITTEN_WORD.findall(text))
        shouted = {
            word for word in words if 1 < len(word) <= MAX_SPELLED_LETTERS and word.isupper()
        }
        capitals |= set() if text.isupper() else {word.lower() for word in shouted}
        others |= {word.lower() for word in words - shouted}
    return capitals - others


def split_compound(word: str, known: Callable[[str], object]) -> tuple[str, ...]:
    """Split a word into as few known words as possible, the shortest as long as possible.

    Of two equally good splits the one with the longer beginning is taken.
    """
    for count in range(2, MAX_COMPOUND_PARTS + 1):
        splits = [parts for parts in _splits(word, count) if all(map(known, parts))]
        if splits:
            return max(splits, key=lambda parts: (min(map(len, parts)), [*map(len, parts)]))
    return ()


def _splits(word: str, count: int) -> Iterator[tuple[str, ...]]:
    for cuts in combinations(range(1, len(word)), count - 1):
        parts = tuple(word[start:end] for start, end in pairwise((0, *cuts, len(word))))
        if min(map(len, parts)) >= MIN_PART_LETTERS:
            yield parts


def _join(parts: Sequence[str], known: Callable[[str], tuple[str, ...]]) -> tuple[str, ...]:
    return tuple(dict.fromkeys(" ".join(phones) for phones in product(*map(known, parts))))


def _guess_all(
    words: Sequence[str], places: Mapping[str, str], guess: Guesser
) -> dict[str, LexiconEntry]:
    if not words:
        return {}
    try:
        guesses = guess(words)
    except FestivalError as error:
        raise CommandsError(
            f'{places[words[0]]}: "{words[0]}" is in no dictionary, and {error}, '
            f"or add the word to {PRONUNCIATIONS_FILE}"
        ) from None
    for word in words:
        if word not in guesses or not PHONES.issuperset(guesses[word].split()):
            raise CommandsError(
                f'{places[word]}: nothing knows how to pronounce "{word}"; '
                f"use another word or add it to {PRONUNCIATIONS_FILE}"
            )
    return {word: LexiconEntry((guesses[word],), GUESS_ORIGIN) for word in words}
