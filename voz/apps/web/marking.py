"""What is recorded of utterances, and what people say that it was; used on the server's thread."""

from __future__ import annotations

import asyncio
from collections.abc import Callable
from pathlib import Path

from voz.apps.recordings.recorder import Recorder
from voz.apps.web.board import Record
from voz.errors import AudioError, ConfigError
from voz.language.sentences.command_set import Commands
from voz.language.sentences.spelling import normalize

MOST_KNOWN = 100
"""Recordings that can be played and marked: more than pages show."""

PATIENCE = 2.0
"""For the disk to take a mark, s."""


class Marking:
    """Knows which utterances of this run have a recording, and corrects what is said in it."""

    def __init__(self, recorder: Recorder | None, commands: Callable[[], Commands]) -> None:
        """Begin with no recording.

        Args:
            recorder: writes them; None if nothing is recorded.
            commands: tells what may have been said.
        """
        self._recorder = recorder
        self._commands = commands
        self._known: dict[str, Record] = {}

    @property
    def note(self) -> str | None:
        """What is to be seen of it all the time; empty if it has failed, None if nothing is."""
        return self._recorder.note if self._recorder else None

    @property
    def known(self) -> list[Record]:
        """The recordings that there are."""
        return list(self._known.values())

    def news(self) -> list[Record]:
        """Take note of what was recorded since the last time."""
        kept = self._recorder.kept if self._recorder else ()
        found = []
        while kept:
            start, file = kept.popleft()
            found.append({"type": "recording", "start": start, "file": file})
            self._known[file] = found[-1]
        while len(self._known) > MOST_KNOWN:
            del self._known[next(iter(self._known))]
        return found

    def path(self, file: str) -> Path | None:
        """Where a recording is; None if it is none of this run."""
        return self._recorder.folder / file if self._recorder and file in self._known else None

    async def mark(self, file: str, said: str | None) -> Record:
        """Let the test set have what was really said.

        Args:
            file: the recording.
            said: the command that it was; None if it was none.

        Returns:
            What all pages are to know of it.

        Raises:
            ConfigError: that is no command.
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
            await asyncio.wait_for(asyncio.wrap_future(done), PATIENCE)
        except asyncio.TimeoutError:
            raise AudioError("the disk does not answer: the mark may be lost") from None
        except (OSError, UnicodeDecodeError) as error:
            raise AudioError(f"{self._recorder.folder}: cannot be written ({error})") from None
        self._known[file] = {**self._known[file], "said": text}
        return self._known[file]
