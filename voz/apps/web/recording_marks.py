"""The recordings of a run, and what people mark as said in them. Event-loop thread only."""

from __future__ import annotations

import asyncio
from collections.abc import Callable
from pathlib import Path

from voz.apps.recordings.recorder import Recorder
from voz.apps.web.event_history import Record
from voz.errors import AudioError, ConfigError
from voz.language.sentences.command_set import Commands
from voz.language.sentences.spelling import normalize

MAX_MARKABLE = 100
"""Recordings that can be played and marked: more than pages show."""

MARK_TIMEOUT = 2.0
"""For the disk to take a mark, s."""


class RecordingMarks:
    """The utterances of this run that have a recording; marks correct what was said in it."""

    def __init__(self, recorder: Recorder | None, commands: Callable[[], Commands]) -> None:
        """Begin with no recording; `recorder` is None if nothing is recorded."""
        self._recorder = recorder
        self._commands = commands
        self._known: dict[str, Record] = {}

    @property
    def note(self) -> str | None:
        """The recorder's status line; empty if it has failed, None if nothing is recorded."""
        return self._recorder.note if self._recorder else None

    @property
    def known(self) -> list[Record]:
        """The last recordings."""
        return list(self._known.values())

    def take_new(self) -> list[Record]:
        """Return the recordings made since the last call."""
        kept = self._recorder.kept if self._recorder else ()
        new = []
        while kept:
            start, file = kept.popleft()
            new.append({"type": "recording", "start": start, "file": file})
            self._known[file] = new[-1]
        while len(self._known) > MAX_MARKABLE:
            del self._known[next(iter(self._known))]
        return new

    def path(self, file: str) -> Path | None:
        """Where a recording is; None if it is none of this run."""
        return self._recorder.folder / file if self._recorder and file in self._known else None

    async def mark(self, file: str, said: str | None) -> Record:
        """Write into the manifest what was really said in a recording, None for no command.

        Returns:
            The recording's record with the mark, for all pages.

        Raises:
            ConfigError: there is no such command.
            AudioError: there is no such recording, or it cannot be marked.
        """
        if self._recorder is None or file not in self._known:
            raise AudioError("that recording is not there any more")
        parse = self._commands().parse(normalize(said)) if said is not None else None
        if said is not None and parse is None:
            raise ConfigError(f'"{said}" is no command: choose one of the list')
        text = parse.text if parse else ""
        done = self._recorder.correct(file, text, "command" if parse else "near-miss")
        try:
            await asyncio.wait_for(asyncio.wrap_future(done), MARK_TIMEOUT)
        except asyncio.TimeoutError:
            raise AudioError("the disk does not answer: the mark may be lost") from None
        except (OSError, UnicodeDecodeError) as error:
            raise AudioError(f"{self._recorder.folder}: cannot be written ({error})") from None
        self._known[file] = {**self._known[file], "said": text}
        return self._known[file]
