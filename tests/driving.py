"""Runs by typed lines and recordings in the test's own process, and the events they give."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

from voz.api.recognizer import Recognizer
from voz.config import Config, default_commands
from voz.control.table import DEFAULT_STATE
from voz.events import Receiver
from voz.language.sentences.command_set import plain_commands
from voz.run.offline import Source, run_paced, run_unpaced
from voz.run.session import OpenRobots
from voz.run.sources import recorded_items, typed_items
from voz.settings import Safety, Speech

COMMANDS = tuple(default_commands().sets[DEFAULT_STATE])
HALTS = default_commands().halts
STARTED, STOPPED = default_commands().replies


def play(
    source: Source,
    *receivers: Receiver,
    safety: Safety | None = None,
    listening: bool = False,
    paced: bool = False,
    **lost: Callable[[], str | None],
) -> None:
    """Drive by a source; `lost` tells of robots, by their names, why they are lost."""

    @contextmanager
    def opened(_tell: object) -> Iterator[OpenRobots]:
        yield OpenRobots(list(receivers), lost)

    settings = Config(safety=safety or Safety(), speech=Speech(enabled=False))
    (run_paced if paced else run_unpaced)(source, settings, listening, opened)


def type_lines(lines: Iterable[str], *receivers: Receiver, **how: Any) -> None:
    """Drive by typed lines."""
    play(lambda now: typed_items(lines, plain_commands(COMMANDS), HALTS, now), *receivers, **how)


def speak(
    recognizer: Recognizer, paths: Iterable[Path], *receivers: Receiver, **how: Any
) -> list[str]:
    """Drive by recordings; gives what could not be read."""
    unreadable: list[str] = []
    play(lambda _: recorded_items(paths, recognizer, unreadable), *receivers, **how)
    return unreadable
