"""What the subcommands read and write besides their results."""

from __future__ import annotations

import sys
from collections.abc import Iterable
from contextlib import ExitStack
from pathlib import Path
from typing import IO, TypeVar

from voz.errors import ConfigError
from voz.files import replaced, told

Item = TypeVar("Item")


def tell(line: str) -> None:
    """Write a line to the user that is no result."""
    print(line, file=sys.stderr)


def warn(problem: str | None) -> None:
    """Write a warning, if there is one."""
    if problem:
        tell(f"warning: {problem}")


def open_text(name: str, files: ExitStack) -> IO[str]:
    """Open a text file until `files` closes; `-` is standard input."""
    if name == "-":
        return sys.stdin
    try:
        # Typed text that is not UTF-8 is no command; it need not end the run.
        return files.enter_context(Path(name).open(encoding="utf-8", errors="replace"))
    except OSError as error:
        raise ConfigError(f"{name}: cannot be read ({error.strerror})") from error


def write_text(name: str, text: str) -> None:
    """Write a text file anew, or it stays as it was; `-` is standard output."""
    if name == "-":
        sys.stdout.write(text)
        return
    with told(name), replaced(Path(name)) as file:
        file.write(text)


def with_bar(items: Iterable[Item], doing: str, total: int | None = None) -> Iterable[Item]:
    """Show a bar while items are taken, unless nobody is there to see it.

    Args:
        items: what is given on.
        doing: what stands beside the bar.
        total: how many items there are; None if they can tell.
    """
    if not sys.stderr.isatty():
        return items
    from rich.console import Console
    from rich.progress import track

    return track(items, doing, total, console=Console(stderr=True), transient=True)
