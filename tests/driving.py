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
from voz.run.clocks import Source
from voz.run.controller import controller_by
from voz.run.parts import by_items
from voz.run.session import Session
from voz.run.sources import recorded_items, typed_items
from voz.run.spec import Part, RunSpec
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

    settings = Config(safety=safety or Safety(), speech=Speech(enabled=False))
    robots = robots_part(*receivers, **lost)
    controller = controller_by(settings, listening)
    spec = RunSpec(controller=controller, settings=settings, outputs=[robots])
    Session(by_items(spec, source, in_real_time=paced)).run()


def robots_part(*receivers: Receiver, **lost: Callable[[], str | None]) -> Part:
    """Robots that are receivers; `lost` tells of them, by their names, why they are lost."""

    @contextmanager
    def connect(session: Session) -> Iterator[None]:
        session.receivers += receivers
        for name, trouble in lost.items():
            session.watch(name, trouble)
        yield

    return connect


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
