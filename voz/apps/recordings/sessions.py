"""Reads sessions: what `voz run --events` wrote, or a bag. An edge."""

from __future__ import annotations

from pathlib import Path

import msgspec

from voz.apps.recordings.bags import is_bag, read_events
from voz.errors import ConfigError
from voz.events import Event
from voz.files import read_text, shown_path

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
