"""Compiled templates as JSON; pure."""

from __future__ import annotations

from collections.abc import Mapping

import msgspec

from voz.language.sentences.automaton import Automaton
from voz.language.sentences.command_set import Commands, Meaning


class StoredCommands(msgspec.Struct, frozen=True):
    """What the file holds.

    Attributes:
        sources: the SHA-256 of each template file, by its path relative to the folder.
        arcs: of the automaton.
        labels: of the automaton.
        meanings: of the labels.
    """

    sources: dict[str, str]
    arcs: list[dict[str, int]]
    labels: list[int]
    meanings: list[Meaning]


def encode_commands(commands: Commands, sources: Mapping[str, str]) -> str:
    """Write commands as JSON; deterministic."""
    automaton = commands.automaton
    stored = StoredCommands(
        dict(sources), automaton.arcs, automaton.labels, list(commands.meanings)
    )
    return msgspec.json.encode(stored).decode() + "\n"


def decode_commands(stored: StoredCommands) -> Commands:
    """The reverse of `encode_commands`."""
    return Commands(Automaton(stored.arcs, stored.labels), stored.meanings)
