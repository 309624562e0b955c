"""Takes a list of commands, or a table of what they do, that is saved during a run."""

from __future__ import annotations

import threading
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import TypeAlias

from voz.config import Config
from voz.control.table import CommandTable
from voz.events import Notice
from voz.inbox import Inbox, Renewal
from voz.language.build import build
from voz.language.command_source import CommandSource
from voz.recognition.recognizer import Recognizer
from voz.robot.user_code import error_line
from voz.run.clocks import Clock
from voz.run.command_check import check_list
from voz.run.renewal import check_renewal, describe_renewal, list_files, read_list_again

RELOAD_CHECK_INTERVAL = 0.5
"""Time between two checks of the files, s; one that is still being written changes meanwhile."""

MAX_WARNINGS = 3
"""Of a new list, that are shown."""

FileVersion: TypeAlias = tuple[int, int, int]
"""Modification time, inode and size of a file."""


@dataclass(frozen=True)
class SettingsFile:
    """Where the settings of a run are, and what reads them again, with the same options."""

    path: Path
    read: Callable[[], Config]


class CommandReload:
    """Watches the files of the commands; what is saved there is used a second later.

    While the commands are being renewed the robot stands still, and afterward it waits for a new
    one. A file that cannot be used is reported in one line, and changes nothing.
    """

    def __init__(
        self,
        recognizer: Recognizer,
        settings: Config,
        settings_file: SettingsFile | None,
        load_functions: Callable[[CommandTable], None],
        inbox: Inbox,
        clock: Clock,
    ) -> None:
        """Begin with what is in use.

        Args:
            recognizer: what is reloaded.
            settings: of the run.
            settings_file: where they are; None if they are in no file.
            load_functions: loads what a new table calls, or raises ConfigError.
            inbox: where new commands go.
            clock: the time of the run.
        """
        self._recognizer = recognizer
        self._settings = settings
        self._settings_file = settings_file
        self._load_functions = load_functions
        self._inbox = inbox
        self._clock = clock
        self._end = threading.Event()
        self._used = self._seen = self._versions()

    @contextmanager
    def watching(self) -> Iterator[None]:
        """Watch the files in a `with` block, on a thread of its own."""
        thread = threading.Thread(target=self._watch, name="voz-reload", daemon=True)
        thread.start()
        try:
            yield
        finally:
            self._end.set()

    def _watch(self) -> None:
        while not self._end.wait(RELOAD_CHECK_INTERVAL):
            now = self._versions()
            complete, self._seen = now == self._seen, now
            if complete and now != self._used:
                changed = [p for p in {**self._used, **now} if self._used.get(p) != now.get(p)]
                self._used = now
                self._take(changed)

    def _take(self, changed: list[Path]) -> None:
        """Check what was saved; if it can be used, stop the robot and use it."""
        files, old = self._recognizer.files, self._settings
        try:
            in_file = self._settings_file
            new = in_file.read() if in_file and in_file.path in changed else old
            listed = not set(changed).isdisjoint(list_files(files))
            source = read_list_again(files, new) if listed else None
            before = self._recognizer.commands
            after = source.commands if source else before
            check_list(after, new.table, source.name if source else "the list of commands")
            check_renewal(old, new, before, after)
            self._load_functions(new.table)
        except Exception as error:  # whatever it is, the next one may be good
            self._inbox.put(Notice(self._clock.now(), _refusal(error)))
            return
        self._inbox.put(Renewal(f"{changed[0]} was saved", self._clock.now(), under_way=True))
        told, table = "", None
        try:
            self._renew_list(source, new.table, files.fingerprint in changed)
            told, table = describe_renewal(old, new, before, self._recognizer.commands), new.table
            self._settings = new
        except Exception as error:
            told = _refusal(error)
        finally:
            self._inbox.put(Renewal(told, self._clock.now(), under_way=False, table=table))

    def _renew_list(self, source: CommandSource | None, table: CommandTable, built: bool) -> None:
        files = self._recognizer.files
        if source:
            warnings = build(Path(source.name), files.folder, source).warnings
            self._used = {**self._used, **_version(files.fingerprint)}
            for warning in warnings[:MAX_WARNINGS]:
                self._inbox.put(Notice(self._clock.now(), warning))
        if source or built:
            self._recognizer.reload(lambda commands: check_list(commands, table, "the new list"))

    def _versions(self) -> dict[Path, FileVersion]:
        files = self._recognizer.files
        own = [self._settings_file.path] if self._settings_file else []
        paths = (*own, *list_files(files), files.fingerprint)
        return {path: version for each in paths for path, version in _version(each).items()}


def _version(path: Path) -> dict[Path, FileVersion]:
    """The version of a file; none while it is being replaced."""
    try:
        found = path.stat()
    except OSError:
        return {}
    return {path: (found.st_mtime_ns, found.st_ino, found.st_size)}


def _refusal(error: Exception) -> str:
    return f"the new commands are not taken: {error_line(error)}"
