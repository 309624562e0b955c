"""Code of users: imported by its name, and its mistakes described in one line."""

from __future__ import annotations

import os
import signal
import sys
import traceback
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from importlib import import_module, invalidate_caches
from pathlib import Path
from typing import Any

from voz.errors import RobotMistake, VozError
from voz.printable import printable
from voz.process.signals import first_signal
from voz.robot.base import Robot

VOZ_FOLDER = str(Path(__file__).parents[1]) + os.sep

IMPORT_MACHINERY = ("<frozen importlib", "importlib/__init__.py")
"""How the names of Python's own files begin and end that stand between voz and theirs."""

MAX_MESSAGE_LENGTH = 1000
"""Characters that are shown of a text from a robot's own code."""


def import_target(target: str) -> Any:
    """Import MODULE:NAME, also from the user's folder; raises whatever that code raises."""
    here = str(Path.cwd())
    if here not in sys.path:
        sys.path.insert(0, here)  # a module beside voz.toml, as `python` itself would find it
    invalidate_caches()  # it may have been written since
    module, _, name = target.partition(":")
    try:
        return getattr(import_module(module), name)
    except ModuleNotFoundError as error:
        if error.name != module:
            raise
        raise ModuleNotFoundError(
            f"there is no module {module} in the folder you are in; name a file without its .py",
            name=module,
        ) from None


def module_file(target: str) -> Path:
    """Return where the module of MODULE:NAME is, if it is in the folder you are in."""
    return Path(*target.partition(":")[0].split(".")).with_suffix(".py")


@contextmanager
def user_errors_as_mistake(name: str) -> Iterator[None]:
    """Turn an error of a robot's own code into a RobotMistake of one line; not a `VozError`."""
    try:
        yield
    except VozError:
        raise
    except (Exception, SystemExit, KeyboardInterrupt) as error:
        if is_by_signal(error):
            raise
        raise RobotMistake(
            f"the robot {name} cannot be used here: {describe_error(error)}"
        ) from error


def describe_error(error: BaseException) -> str:
    """Describe an error in one line, with its place in the user's file."""
    message = " ".join(_text(lambda: _message(error)).split())
    said = f"{type(error).__name__}: {message}" if message else type(error).__name__
    place = _text(lambda: _place(error))
    return printable(f"{said} ({place})" if place else said)


def error_line(error: BaseException) -> str:
    """Describe any error in one line; a `VozError` by its own message."""
    return (
        printable(_text(lambda: str(error)))
        if isinstance(error, VozError)
        else describe_error(error)
    )


def lost_reason(robot: Robot) -> str | None:
    """Ask a robot whether it is lost; return one printable line, whatever it returns."""
    said: object = robot.lost()
    if not said:
        return None
    if not isinstance(said, str):
        raise TypeError(f"lost() returned {type(said).__name__}; return a text, or None")
    return printable(" ".join(said[:MAX_MESSAGE_LENGTH].split()))


def _text(ask: Callable[[], str]) -> str:
    """Get a text from a robot's own code; empty if that raises, too."""
    try:
        return ask()[:MAX_MESSAGE_LENGTH]
    except BaseException:
        return ""


def _message(error: BaseException) -> str:
    return str(error.msg if isinstance(error, SyntaxError) else error)


def _place(error: BaseException) -> str:
    if isinstance(error, SyntaxError) and error.filename and Path(error.filename).is_file():
        return _shown(error.filename, error.lineno)
    frames = [f for f in traceback.extract_tb(error.__traceback__) if _is_theirs(f.filename)]
    # Frames in libraries that their code calls are left out: users cannot mend those.
    own = [f for f in frames if Path(f.filename).parent == Path(frames[0].filename).parent]
    return _shown(own[-1].filename, own[-1].lineno) if own else ""


def _is_theirs(file: str) -> bool:
    return not (
        file.startswith((VOZ_FOLDER, IMPORT_MACHINERY[0])) or file.endswith(IMPORT_MACHINERY[1])
    )


def _shown(file: str, line: int | None) -> str:
    here = Path.cwd()
    path = Path(file)
    return f"{path.relative_to(here) if path.is_relative_to(here) else path}, line {line}"


def is_by_signal(error: BaseException) -> bool:
    """Whether an error ends the program because of a signal, such as Ctrl-C."""
    by_python = signal.getsignal(signal.SIGINT) is signal.default_int_handler
    return first_signal() is not None or (isinstance(error, KeyboardInterrupt) and by_python)
