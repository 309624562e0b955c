"""Calls of the `voz` command, and what they give."""

from __future__ import annotations

import json
import subprocess
import sys
from typing import Any

VOZ = [sys.executable, "-c", "import sys; from voz.cli import main; sys.exit(main())"]
"""The command in a process of its own."""

HANGS = 600.0
"""Whatever has not ended by then hangs, s: on a busy machine a start alone takes many seconds."""


class Result:
    def __init__(self, code: int, out: str, err: str) -> None:
        self.code, self.out, self.err = code, out, err
        assert "Traceback" not in err

    @property
    def json(self) -> list[dict[str, Any]]:
        return [json.loads(line) for line in self.out.splitlines()]

    @property
    def complaint(self) -> str:
        """What a wrong call says: one line."""
        assert self.code == 2
        (line,) = self.err.splitlines()
        return line


def in_process(*arguments: object, **options: Any) -> Result:
    command = [*VOZ, *map(str, arguments)]
    done = subprocess.run(command, capture_output=True, text=True, timeout=HANGS, **options)
    return Result(done.returncode, done.stdout, done.stderr)
