"""Reads sessions: what `voz run --events` wrote, or a bag. An edge."""

from __future__ import annotations

from contextlib import suppress
from pathlib import Path
from typing import TypeAlias

import msgspec

from voz.apps.recordings.bags import is_bag, read_events
from voz.apps.recordings.manifest import MANIFEST_NAME, parse_lines
from voz.errors import ConfigError
from voz.events import Event, Utterance
from voz.files import read_text, shown_path

FOLDER_ADVICE = "name the folder of `voz run --record`"

UtteranceKey: TypeAlias = tuple[float, float, str]
"""Where an utterance begins and ends, s of the run, and what was heard."""

SESSION_ADVICE = "name what `voz run --events FILE` wrote, or a bag"


def read_session(path: Path) -> list[Event]:
    """Read the events of a run: lines of JSON, or a bag of ROS 1 or 2.

    Raises:
        ConfigError: it cannot be read, or has no event.
    """
    events = read_events(path) if is_bag(path) else _written(path)
    if not events:
        raise ConfigError(f"{shown_path(path)}: has no events; {SESSION_ADVICE}")
    return events


def read_recordings(folder: Path) -> dict[UtteranceKey, Path]:
    """Find what `voz run --record` kept of each utterance.

    Raises:
        ConfigError: there is no such folder, or it has no recording with its event.
    """
    manifest = folder / MANIFEST_NAME
    decoder = msgspec.json.Decoder(Utterance)
    found: dict[UtteranceKey, Path] = {}
    for line in parse_lines(read_text(manifest, ConfigError, FOLDER_ADVICE)):
        name, event = line.fields[0], line.fields[-1]
        with suppress(msgspec.DecodeError, RecursionError):
            if Path(name).name == name:  # a user's own rows may name others, and have no event
                found[utterance_key(decoder.decode(event))] = folder / name
    if not found:
        raise ConfigError(f"{shown_path(folder)}: has no recordings; {FOLDER_ADVICE}")
    return found


def utterance_key(utterance: Utterance) -> UtteranceKey:
    """Return by what an utterance is found: its record may have been made before it was obeyed."""
    return utterance.start, utterance.end, utterance.text


def _written(path: Path) -> list[Event]:
    """Read lines of JSON; a last one that was cut short is left out."""
    lines = read_text(path, ConfigError, SESSION_ADVICE).split("\n")
    decoder = msgspec.json.Decoder(Event)
    events: list[Event] = []
    for number, line in enumerate(lines[:-1], start=1):
        try:
            events.append(decoder.decode(line))
        except (msgspec.DecodeError, RecursionError) as error:
            why = f"is not an event of voz ({error})"
            raise ConfigError(f"{shown_path(path)}:{number}: {why}; {SESSION_ADVICE}") from None
    return events
