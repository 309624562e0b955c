"""The robot's name: how it is said, and how well it can be told from other speech."""

from __future__ import annotations

from dataclasses import replace

from voz.errors import CommandsError, ConfigError
from voz.events import NO, YES
from voz.language.language_files import list_sources
from voz.language.pronunciation import (
    GUESS_ORIGIN,
    PRONUNCIATIONS_FILE,
    dictionary_entries,
)
from voz.recognition.accents import spellings, with_british
from voz.recognition.language import Language
from voz.recognition.name_evidence import read_weights
from voz.recognition.phoneme_scorer import PhonemeScorer
from voz.settings import Recognition

SETTING = "[recognition] name"

GOOD_LOG_ODDS = 3.8
"""A name whose log-odds are usually lower is missed more often."""

COMMANDS_BESIDE_NAME = 1000
"""Commands with which a name is compared; of more, a sample."""


def with_more_words(language: Language, settings: Recognition) -> Language:
    """Add the words of the robot's name, and of answers to what it asks, to a language.

    Raises:
        ConfigError: the language is not English, the search is not for whole commands, nobody
            knows how to say the name, or a command is the same or begins so.
    """
    name = settings.name
    if not settings.more_than_commands:
        return language
    if not language.spoken.is_english:
        raise ConfigError(
            f"`name` and `ask` of [recognition] work in English alone, not {language.spoken.name}"
        )
    if settings.search == "lm":
        raise ConfigError('`name` and `ask` of [recognition] need search = "grammar"')
    if name and (name in language.commands or language.commands.has_continuation(name)):
        raise ConfigError(f'{SETTING}: a command is or begins with "{name}"; give another name')
    from voz.language.command_source import pronounce_words  # builds lists, which most runs do not

    known = spellings(language.dictionary)
    places = {word: SETTING for word in (*name.split(), YES, NO) if word not in known}
    sources = list_sources(language.files)
    try:
        entries = pronounce_words(sources[0].parent if sources else None, places)
    except CommandsError as error:
        raise ConfigError(str(error)) from None
    more = {word: tuple(phones.split()) for word, phones in dictionary_entries(entries)}
    return replace(
        language,
        pronunciations={**language.pronunciations, **with_british(more)},
        guessed=frozenset(word for word in entries if entries[word].origin == GUESS_ORIGIN),
    )


def usual_log_odds(network: PhonemeScorer, name: str) -> float:
    """The log-odds of a name, in the mean, that is said in noise."""
    weights = read_weights()
    return weights.constant + float(weights.typical[network.phone_numbers(name)].sum())


def advice_on_name(language: Language, network: PhonemeScorer, name: str) -> str:
    """Say what would make a name better; empty if it is good."""
    if command := _sounds_like(language, name):
        return f'the name "{name}" sounds like "{command}"; better is one of other sounds'
    for word in name.split():
        if word in language.guessed:
            guess = " ".join(language.pronunciations[word])
            return (
                f'no dictionary has "{word}" of the name "{name}", and {guess} is a guess: '
                f"correct it in {PRONUNCIATIONS_FILE} beside the command list"
            )
    if usual_log_odds(network, name) >= GOOD_LOG_ODDS:
        return ""
    longer = f"{name} robot" if name.startswith("hey ") else f"hey {name}"
    return (
        f'the name "{name}" has few sounds, or such as many words have: it is missed more often '
        f'than a longer one; better is "{longer}"'
    )


def _sounds_like(language: Language, name: str) -> str:
    """The command that sounds most like a name; empty if none sounds much like it."""
    from voz.language.similarity import find_similar
    from voz.language.similarity_report import WARNING_SIMILARITY

    said = {
        word: [" ".join(phones) for phones in ways]
        for word, ways in spellings(language.pronunciations).items()
    }
    pairs = [
        pair
        for command in language.commands.sample(COMMANDS_BESIDE_NAME)
        for pair in find_similar((command, name), said, at_least=WARNING_SIMILARITY)
    ]
    return max(pairs, key=lambda pair: pair.similarity).first if pairs else ""
