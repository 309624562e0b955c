"""What subcommands read and write: text, events, progress."""

from __future__ import annotations

import sys
from collections.abc import Iterable, Iterator
from contextlib import ExitStack, contextmanager, suppress
from io import TextIOWrapper
from pathlib import Path
from typing import IO, TypeVar

from voz.errors import ConfigError
from voz.events import Event, Receiver, to_json
from voz.files import atomic_write, os_errors_as_config_error
from voz.printable import printable

Item = TypeVar("Item")

MAX_INPUT_LINE = 10_000
"""Of typed commands, characters, or of names of recordings, bytes: `/dev/zero` is one line
without an end."""


def show(*lines: str) -> None:
    """Write lines of results for people."""
    for line in lines:
        show_raw(printable(line))


def show_raw(line: str) -> None:
    """Write a line of results for programs, as it is; raises as `writing_results`."""
    with writing_results():
        print(line, flush=True)


@contextmanager
def writing_results() -> Iterator[None]:
    """Turn an OSError of a `with` block into a ConfigError; a BrokenPipeError stays one."""
    try:
        yield
    except BrokenPipeError:
        raise
    except OSError as error:
        raise ConfigError(f"the results cannot be written ({error.strerror})") from error


def info(line: str) -> None:
    """Write a line to the user that is not a result."""
    with suppress(OSError):  # if nobody can read it, the program goes on
        print(printable(line), file=sys.stderr)


def warn(problem: str | None) -> None:
    """Write a warning, if there is one."""
    if problem:
        info(f"warning: {problem}")


def open_text(name: str, files: ExitStack) -> Iterator[str]:
    """Open a text file until `files` closes, and yield its lines; `-` is standard input.

    Raises:
        ConfigError: it cannot be opened; later, it cannot be read or a line has no end.
    """
    # Typed text that is not UTF-8 is no command; it need not end the run.
    if name == "-":
        if isinstance(sys.stdin, TextIOWrapper):
            sys.stdin.reconfigure(encoding="utf-8", errors="replace")
        return _lines(sys.stdin, name)
    try:
        file = Path(name).open(encoding="utf-8", errors="replace")  # noqa: SIM115
        return _lines(files.enter_context(file), name)
    except OSError as error:
        raise ConfigError(f"{name}: cannot be read ({error.strerror})") from error


def _lines(stream: IO[str], name: str) -> Iterator[str]:
    try:
        while line := stream.readline(MAX_INPUT_LINE + 1):
            if len(line) > MAX_INPUT_LINE:
                raise ConfigError(f"{name}: has a line without an end; write a command a line")
            yield line
    except OSError as error:
        raise ConfigError(f"{name}: cannot be read ({error.strerror})") from error


def write_text(name: str, text: str) -> None:
    """Write a text file, all of it or nothing; `-` is standard output."""
    if name == "-":
        sys.stdout.write(text)
        return
    with os_errors_as_config_error(name), atomic_write(Path(name)) as file:
        file.write(text)


def with_bar(items: Iterable[Item], doing: str, total: int | None = None) -> Iterable[Item]:
    """Show a bar, called `doing`, while items are taken, unless nobody sees it."""
    if not sys.stderr.isatty():
        return items
    from rich.console import Console
    from rich.progress import track

    return track(items, doing, total, console=Console(stderr=True), transient=True)


@contextmanager
def event_log(name: str) -> Iterator[Receiver]:
    """Open a file for events in a `with` block; `-` is standard output.

    Yields what writes an event at once: a signal ends the run between two of them.

    Raises:
        ConfigError: it cannot be opened or written.
        BrokenPipeError: nobody reads standard output any more.
    """

    def receive(event: Event) -> None:
        with os_errors_as_config_error(name):
            stream.write(f"{to_json(event)}\n".encode())

    with os_errors_as_config_error(name):
        # Unbuffered: nothing is left to be written at the end, where it could fail or block.
        file = sys.stdout.fileno() if name == "-" else name
        stream = open(file, "wb", buffering=0, closefd=name != "-")  # noqa: SIM115
    with stream:
        yield receive
