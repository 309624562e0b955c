"""Pronunciations by espeak-ng (https://github.com/espeak-ng/espeak-ng), a program. Does I/O.

It is called once for a list, when its language files are made: these need it no more.
"""

from __future__ import annotations

import subprocess
from collections.abc import Mapping, Sequence
from dataclasses import replace

from voz.errors import CommandsError, LanguageError
from voz.language.phones import in_english, known_phones, parse_phones
from voz.language.pronunciation import LexiconEntry
from voz.language.sentences.text_lines import PRONUNCIATIONS_FILE
from voz.language.spoken_language import ENGLISH_NAMES, known_languages

TIME_LIMIT = 60.0
"""For a whole list, s; 20,000 words take 2."""

ORIGIN = "espeak-ng"

ACCENTS = {"es": ("es", "es-419")}
"""Languages of espeak-ng that pronounce each word, where accents differ by whole phones: `cerveza`
begins as in Spain, or as in America."""


def accents_of(language: str) -> tuple[str, ...]:
    """The languages of espeak-ng that pronounce the words of a language."""
    return ACCENTS.get(language, (language,))


def pronounce_by_espeak(
    places: Mapping[str, str], user: Mapping[str, tuple[str, ...]], language: str
) -> dict[str, LexiconEntry]:
    """Find out how words are pronounced, each alone: by the user, else by espeak-ng.

    `places` has where each stands, as `FILE:LINE`; the entries are sorted by word.

    Raises:
        CommandsError: espeak-ng does not pronounce a word, or by a phone that no table has.
        LanguageError: espeak-ng is missing, or does not speak the language.
    """
    unknown = [word for word in places if word not in user]
    spoken = [run_espeak(unknown, accent) for accent in accents_of(language)] if unknown else []
    entries = {}
    for word, place in places.items():
        ways = user.get(word) or [found[word] for found in spoken]
        origin = PRONUNCIATIONS_FILE if word in user else ORIGIN
        entries[word] = _entry(word, place, [way.split() for way in ways], origin)
    return dict(sorted(entries.items()))


def _entry(word: str, place: str, ways: Sequence[Sequence[str]], origin: str) -> LexiconEntry:
    advice = f"write its phones in {PRONUNCIATIONS_FILE} beside the list"
    if not all(ways):
        raise CommandsError(f'{place}: espeak-ng does not pronounce "{word}"; {advice}')
    strange = [phone for way in ways for phone in way if phone not in known_phones()]
    if strange:
        raise CommandsError(
            f'{place}: espeak-ng pronounces "{word}" with the phone {strange[0]}, which voz does '
            f"not know; {advice}"
        )
    near = dict.fromkeys(" ".join(in_english(way)) for way in ways)
    return LexiconEntry(tuple(near), origin, tuple(dict.fromkeys(map(" ".join, ways))))


def with_ipa(entries: dict[str, LexiconEntry], language: str) -> dict[str, LexiconEntry]:
    """Add phones for the network to words that an acoustic model of the user's pronounces.

    Nothing is added in a language whose phones voz does not know, in English, whose dictionary the
    network hears, or without espeak-ng.
    """
    if language not in {known.code for known in known_languages()} - ENGLISH_NAMES:
        return entries
    try:
        heard = pronounce_by_espeak(dict.fromkeys(entries, ""), {}, language)
    except (CommandsError, LanguageError):
        return entries
    return {word: replace(entry, ipa=heard[word].ipa) for word, entry in entries.items()}


def run_espeak(words: Sequence[str], language: str) -> dict[str, str]:
    """Let espeak-ng pronounce words, each alone; raises LanguageError.

    Returns:
        The phones of each word, such as "a β a n θ a".
    """
    lines = written_by_espeak(words, language)
    return {word: " ".join(parse_phones(line)) for word, line in zip(words, lines, strict=True)}


def written_by_espeak(words: Sequence[str], language: str) -> list[str]:
    """What espeak-ng writes for words, each alone, as `--sep=_` asks; raises LanguageError."""
    command = ["espeak-ng", "-q", "-b", "1", "--ipa", "--sep=_", "-v", language]
    try:
        done = subprocess.run(
            command,
            input="".join(f"{word}\n" for word in words),
            capture_output=True,
            encoding="utf-8",
            timeout=TIME_LIMIT,
        )
    except FileNotFoundError:
        raise LanguageError(
            "espeak-ng is not installed, which pronounces the words of other languages than "
            "English; install it with: sudo apt-get install espeak-ng"
        ) from None
    except (OSError, ValueError, subprocess.TimeoutExpired) as error:
        raise LanguageError(f"espeak-ng failed ({error}); reinstall it") from None
    lines = done.stdout.splitlines()
    if done.returncode:
        raise LanguageError(
            f'espeak-ng does not speak "{language}"; `espeak-ng --voices` lists the languages that '
            "it speaks, and `voz language add` takes a model of another"
        )
    if len(lines) != len(words):
        raise LanguageError(f"espeak-ng read {len(words)} words and wrote {len(lines)}; update it")
    return lines
