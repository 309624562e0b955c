"""Addresses that no worker survives, for processes that have this folder in PYTHONPATH.

`poison://` kills who opens it, `crash://` lets it crash in C, `endless://` never ends, `hungry://`
takes all memory, `once:///FILE` kills only the first.
"""

from __future__ import annotations

import ctypes
import os
import signal
import time
from pathlib import Path
from typing import Any

from fsspec import AbstractFileSystem, register_implementation


def _kill() -> None:
    os.kill(os.getpid(), signal.SIGKILL)


def _crash() -> None:
    ctypes.string_at(0)


def _wait() -> None:
    time.sleep(600)


def _eat() -> None:
    _EATEN.append(b"x" * 10**12)


def _once(path: str) -> None:
    if not Path(path).exists():
        Path(path).touch()
        _kill()


_EATEN: list[bytes] = []

HARM = {"poison": _kill, "crash": _crash, "endless": _wait, "hungry": _eat}


class Harmful(AbstractFileSystem):
    def _open(self, path: str, *_: Any, **__: Any) -> Any:
        if self.protocol == "once":
            _once(path)
        else:
            HARM[str(self.protocol)]()
        raise FileNotFoundError(path)


for name in (*HARM, "once"):
    register_implementation(name, type(name, (Harmful,), {"protocol": name}))
