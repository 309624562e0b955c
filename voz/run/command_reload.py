"""Loads a new list of commands during a run, when `voz build-lm` has run again."""

from __future__ import annotations

import threading
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from typing import TypeAlias

from voz.control.table import CommandTable
from voz.language.generated.language_files import LanguageFiles, list_name
from voz.recognition.recognizer import Recognizer
from voz.robot.user_code import error_line
from voz.run.command_check import check_list

RELOAD_CHECK_INTERVAL = 1.0
"""Time between two checks of the files, s."""

FileVersion: TypeAlias = tuple[int, int] | None
"""Modification time and inode of a file; None if there is none."""


@contextmanager
def reload_on_change(
    recognizer: Recognizer, table: CommandTable, warn: Callable[[str, bool], None]
) -> Iterator[None]:
    """Reload a recognizer in a `with` block whenever its language files are new.

    The old commands work until the new ones are loaded, on a thread of its own.

    Args:
        recognizer: what is reloaded.
        table: what commands do; a list that cannot stop the robot is not loaded.
        warn: takes a line, and whether it is good news, on any thread.
    """
    end = threading.Event()
    files = recognizer.files
    before = _file_version(files)

    def reload_when_new() -> None:
        seen = before
        while not end.wait(RELOAD_CHECK_INTERVAL):
            if (now := _file_version(files)) not in (seen, None):
                seen = now
                _reload(recognizer, table, warn)

    thread = threading.Thread(target=reload_when_new, name="voz-reload", daemon=True)
    thread.start()
    try:
        yield
    finally:
        end.set()


def _reload(recognizer: Recognizer, table: CommandTable, warn: Callable[[str, bool], None]) -> None:
    files = recognizer.files
    try:
        recognizer.reload(lambda commands: check_list(commands, table, list_name(files)))
    except Exception as error:  # whatever it is, the next list may be good
        warn(f"the new commands are not taken: {error_line(error)}", False)
    else:
        warn(f"there are new commands: {len(recognizer.commands):,} sentences", True)


def _file_version(files: LanguageFiles) -> FileVersion:
    try:
        found = files.fingerprint.stat()
    except OSError:
        return None
    return found.st_mtime_ns, found.st_ino
