"""Runs by typed lines and recordings in the test's own process, and the events they give."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Mapping
from contextlib import contextmanager
from pathlib import Path
from typing import Any, NamedTuple

from voz.config import Config, usual_commands
from voz.control.bound import Place
from voz.control.table import USUAL
from voz.events import Receiver
from voz.language.templates.commands import plain_commands
from voz.recognition.recognizer import Recognizer
from voz.run.offline import Played, run_at_its_pace, run_at_once
from voz.run.sources import lines_typed, recordings_played
from voz.settings import Safety, Speech

COMMANDS = tuple(usual_commands().sets[USUAL])
STARTED, STOPPED = usual_commands().replies


class Robots(NamedTuple):
    receivers: list[Receiver]
    troubles: Mapping[str, Callable[[], str | None]]
    odometry: Callable[[float], Place | None] = lambda _: None
    show: Callable[[str], None] = lambda _: None


def play(
    played: Played,
    *receivers: Receiver,
    safety: Safety | None = None,
    listening: bool = False,
    paced: bool = False,
    **lost: Callable[[], str | None],
) -> None:
    """Drive by what is played; `lost` tells of robots, by their names, why they are lost."""

    @contextmanager
    def opened(_tell: object) -> Iterator[Robots]:
        yield Robots(list(receivers), lost)

    settings = Config(safety=safety or Safety(), speech=Speech(enabled=False))
    (run_at_its_pace if paced else run_at_once)(played, settings, listening, opened)


def type_lines(lines: Iterable[str], *receivers: Receiver, **how: Any) -> None:
    """Drive by typed lines."""
    play(lambda now: lines_typed(lines, plain_commands(COMMANDS), now), *receivers, **how)


def speak(
    recognizer: Recognizer, paths: Iterable[Path], *receivers: Receiver, **how: Any
) -> list[str]:
    """Drive by recordings; gives what could not be read."""
    unreadable: list[str] = []
    play(lambda _: recordings_played(paths, recognizer, unreadable), *receivers, **how)
    return unreadable
