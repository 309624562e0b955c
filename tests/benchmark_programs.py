"""The programs of `benchmarks/` as they are called, and the tables that they print."""

from __future__ import annotations

import subprocess
import sys

from recordings import ROOT


def printed(name: str, *arguments: object) -> list[str]:
    """The lines that a program prints."""
    script = ROOT / "benchmarks" / f"{name}.py"
    command = [sys.executable, str(script), *map(str, arguments)]
    done = subprocess.run(command, capture_output=True, text=True)
    assert done.returncode == 0, done.stdout + done.stderr
    return done.stdout.splitlines()


def cells(lines: list[str]) -> list[list[str]]:
    """The rows of the tables among them."""
    return [line[2:-2].split(" | ") for line in lines if line.startswith("| ")]
