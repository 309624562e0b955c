"""Guesses pronunciations by festival's letter-to-sound rules. Runs festival."""

from __future__ import annotations

import re
import subprocess
from collections.abc import Iterable, Sequence

# festival's time for a word grows with the words before it (400 take 2 s, 1600 more than 40 s),
# so a long list is given to several processes, one after the other.
WORDS_PER_PROCESS = 200
FESTIVAL_TIME_LIMIT = 60.0  # s for one process, which takes under one second on an idle desktop

# Festival's US phones ("radio") that the acoustic model calls otherwise; the rest are the same
# in upper case. None is silence.
_PHONES = {
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
        answer = _run_festival(_program(letters[start : start + WORDS_PER_PROCESS]))
        guesses.update(_read_answer(answer))
    return {word: guesses[spelling] for word, spelling in spellings.items() if spelling in guesses}


def _program(words: Iterable[str]) -> str:
    lines = ["(setup_cmu_lex)"]  # whatever voice the user's .festivalrc selects
    for word in words:
        if not re.fullmatch("[a-z]+", word):  # anything else could be Scheme
            raise ValueError(f"not a plain word: {word!r}")
        lines.append(f'(print (lex.lookup "{word}" nil))')
    return "\n".join(lines) + "\n"


def _run_festival(program: str) -> str:
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
        known = [_PHONES.get(phone, phone.upper()) for phone in phones]
        spoken = " ".join(phone for phone in known if phone)
        if match and spoken:
            guesses[match.group(1)] = spoken
    return guesses
