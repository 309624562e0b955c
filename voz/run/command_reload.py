"""Takes a list of commands, or a table of what they do, that is saved during a run."""

from __future__ import annotations

import errno
import os
import stat
import threading
from collections.abc import Callable, Iterable, Iterator, Sequence
from contextlib import contextmanager, suppress
from dataclasses import dataclass
from pathlib import Path
from typing import TypeAlias

from voz.config import Config
from voz.control.messages import Renewal
from voz.control.table import CommandTable
from voz.errors import VozError
from voz.events import Notice
from voz.files import shown_path
from voz.inbox import Inbox
from voz.language.build import build
from voz.language.command_source import CommandSource
from voz.recognition.engine import RecognitionEngine
from voz.robot.user_code import error_line, module_file
from voz.run.clocks import Clock
from voz.run.command_check import (
    check_list,
    check_renewal,
    describe_renewal,
    list_files,
    matched_settings,
    read_list_again,
)

RELOAD_CHECK_INTERVAL = 0.5
"""Time between two checks of the files, s; one that is still being written changes meanwhile."""

READ_TIMEOUT = 5.0
"""After which what reads the files is not waited for, s: a function's import may never end."""

MAX_WARNINGS = 3
"""Of a new list, or about files that are gone, that are shown."""

GONE = "is gone"

FileVersion: TypeAlias = tuple[int, int, int] | str
"""Modification time, inode and size of a file; or what is wrong with it, for people."""


@dataclass(frozen=True)
class SettingsFile:
    """Where the settings of a run are, and what reads them again, with the same options."""

    path: Path
    read: Callable[[], Config]


@dataclass(frozen=True)
class NewCommands:
    """What was read of files that were saved, and can be used."""

    changed: Sequence[Path]
    settings: Config
    source: CommandSource | None


class Reading:
    """Reads files that were saved, on a thread of its own, for it may never end."""

    def __init__(self, read: Callable[[Reading], NewCommands]) -> None:
        """Begin; `read` keeps `doing` and `advice` up to date, for people."""
        self.doing, self.advice = "reading the files", ""
        self.told_late = False
        self._result: NewCommands | BaseException | None = None
        self._thread = threading.Thread(
            target=self._work, args=(read,), name="voz-reload-reading", daemon=True
        )
        self._thread.start()

    def _work(self, read: Callable[[Reading], NewCommands]) -> None:
        try:
            self._result = read(self)
        except BaseException as error:  # `sys.exit` in a user's module too
            self._result = error

    def result(self, timeout: float) -> NewCommands | BaseException | None:
        """What was read, or why it cannot be used; None if that is not known after a time, s."""
        self._thread.join(timeout)
        return self._result


class CommandReload:
    """Watches the files of the commands; what is saved there is used a second later.

    While the commands are being renewed the robot stands still, and afterward it waits for a new
    one. A file that cannot be used is reported in one line, and changes nothing.
    """

    def __init__(
        self,
        recognizer: RecognitionEngine,
        settings: Config,
        settings_file: SettingsFile | None,
        load_functions: Callable[[CommandTable], None],
        *,
        inbox: Inbox,
        clock: Clock,
    ) -> None:
        """Begin with what is in use.

        `settings_file` is None if the settings are in no file. `load_functions` loads what a new
        table calls, or raises ConfigError.
        """
        self._recognizer = recognizer
        self._settings = settings
        self._settings_file = settings_file
        self._load_functions = load_functions
        self._inbox = inbox
        self._clock = clock
        self._end = threading.Event()
        self._listed: list[Path] = []  # the list, and what is read with it
        self._find_listed()
        self._used = self._seen = self._versions()
        self._told: set[str] = set()  # the warnings of lists, which would only come again
        self._reading: Reading | None = None

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
            try:
                self.look()
            except Exception as error:  # whatever it is, the next save may be good
                self._tell(_refusal(error))

    def look(self) -> None:
        """Take what was saved since, once it has not changed between two calls."""
        now = self._versions()
        complete, self._seen = now == self._seen, now
        changed = [path for path in now if self._used.get(path) != now[path]]
        if complete and changed:
            self._used = now
            own = [path for path in changed if path in self._own_code()]
            for path in own:
                self._tell(f"{shown_path(path)} was saved: start voz again to take it")
            changed = [path for path in changed if path not in own]
            lost = [path for path in changed if isinstance(now[path], str)]
            for path in lost[:MAX_WARNINGS]:
                self._tell(f"{shown_path(path)} {now[path]}: the commands stay as they were")
            if saved := [path for path in changed if path not in lost]:
                self._reading = Reading(lambda reading: self._read(saved, reading))
        if self._reading:
            self._take(self._reading)

    def _read(self, changed: Sequence[Path], reading: Reading) -> NewCommands:
        """Read what was saved; raises VozError, or what a user's module raises."""
        files, old = self._recognizer.files, self._settings
        in_file = self._settings_file
        new = in_file.read() if in_file and in_file.path in changed else old
        listed = not set(changed).isdisjoint(self._listed)
        source = read_list_again(files, new) if listed else None
        before = self._recognizer.commands
        after = source.commands if source else before
        new = matched_settings(new, after)
        check_list(after, new.table, source.name if source else "the list of commands")
        check_renewal(old, new, before, after)
        if calls := sorted(_functions(new.table) - _functions(old.table)):
            reading.doing, reading.advice = (
                f"importing {calls[0]}",
                "; mend it, and start voz again",
            )
        self._load_functions(new.table)
        return NewCommands(changed, new, source)

    def _take(self, reading: Reading) -> None:
        """Use what was read; if it is late, go on watching, as a later save may be good."""
        read = reading.result(0 if reading.told_late else READ_TIMEOUT)
        if read is None:
            if not reading.told_late:
                late = f"{reading.doing} has not ended after {READ_TIMEOUT:g} s{reading.advice}"
                self._tell(f"the new commands are not taken: {late}")
            reading.told_late = True
            return
        self._reading = None
        if isinstance(read, BaseException):
            self._tell(_refusal(read))
        else:
            self._use(read)

    def _use(self, read: NewCommands) -> None:
        """Stop the robot, and use the new commands."""
        files, old, new = self._recognizer.files, self._settings, read.settings
        before = self._recognizer.commands
        saved = f"{shown_path(read.changed[0])} was saved"
        self._inbox.put(Renewal(saved, self._clock.now(), under_way=True))
        told, table = "", None
        try:
            self._renew_list(read.source, new.table, files.fingerprint in read.changed)
            told, table = describe_renewal(old, new, before, self._recognizer.commands), new.table
            self._settings = new
        except Exception as error:
            told = _refusal(error)
        finally:
            self._inbox.put(Renewal(told, self._clock.now(), under_way=False, table=table))

    def _renew_list(self, source: CommandSource | None, table: CommandTable, built: bool) -> None:
        files = self._recognizer.files
        if source:
            before = self._recognizer.commands
            warnings = build(Path(source.name), files.folder, source, before=before).warnings
            self._used = {**self._used, **_versions([files.fingerprint])}
            untold = [warning for warning in warnings if warning not in self._told]
            self._told.update(untold)
            for warning in untold[:MAX_WARNINGS]:
                self._tell(warning)
        if source or built:
            self._recognizer.reload(lambda commands: check_list(commands, table, "the new list"))
            self._find_listed()
            new = [path for path in self._listed if path not in self._used]  # which it imports now
            self._used = {**self._used, **_versions(new)}

    def _find_listed(self) -> None:
        with suppress(VozError, OSError):  # else those of before are watched
            self._listed = list_files(self._recognizer.files)

    def _versions(self) -> dict[Path, FileVersion]:
        own = [self._settings_file.path] if self._settings_file else []
        code = [path for path in self._own_code() if path.is_file()]
        return _versions([*own, *code, *self._listed, self._recognizer.files.fingerprint])

    def _own_code(self) -> list[Path]:
        """The modules of the user's robots and functions, which are imported once."""
        targets = {name for name in self._settings.robot if ":" in name}
        return [module_file(target) for target in targets | _functions(self._settings.table)]

    def _tell(self, text: str) -> None:
        self._inbox.put(Notice(self._clock.now(), text))


def _versions(paths: Iterable[Path]) -> dict[Path, FileVersion]:
    return {path: _version(path) for path in paths}


def _version(path: Path) -> FileVersion:
    """The version of a file that can be read; else what is there, without opening it."""
    try:
        found = path.stat()
    except (FileNotFoundError, NotADirectoryError):
        return GONE
    except (OSError, ValueError) as error:
        return f"cannot be read ({getattr(error, 'strerror', error)})"
    if stat.S_ISDIR(found.st_mode):
        return "is a folder now"
    if not stat.S_ISREG(found.st_mode):
        return "is no file any more"
    if not os.access(path, os.R_OK, effective_ids=True):
        return f"cannot be read ({os.strerror(errno.EACCES)})"
    return found.st_mtime_ns, found.st_ino, found.st_size


def _functions(table: CommandTable) -> set[str]:
    return {str(step.call[0]) for _, _, step in table.all_steps() if step.call}


def _refusal(error: BaseException) -> str:
    return f"the new commands are not taken: {error_line(error)}"
