"""The steps of docs/lesson.md, one after the other, as its reader types them."""

from __future__ import annotations

import os
import re
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path

import pytest
from documents import BLOCK
from recordings import ROOT

pytestmark = pytest.mark.slow

HERE = "the lesson is in "


def blocks() -> Iterator[tuple[str, str]]:
    """The blocks of the lesson: language and text."""
    text = (ROOT / "docs" / "lesson.md").read_text(encoding="utf-8")
    yield from ((found[2], found[3]) for found in BLOCK.finditer(text))


def typed(block: str, folder: Path) -> tuple[str, Path]:
    """What commands print that are typed in a folder, and the folder that they end in."""
    path = f"{Path(sys.executable).parent}:{os.environ['PATH']}"
    done = subprocess.run(
        ["sh", "-e"],
        input=f"{block}echo '{HERE}'$PWD\n",
        cwd=folder,
        env=os.environ | {"PATH": path, "PYTHONPATH": str(ROOT)},
        stdout=subprocess.PIPE,
        stderr=subprocess.STDOUT,
        text=True,
    )
    assert done.returncode == 0, done.stdout
    printed, _, last = done.stdout.rpartition(HERE)
    return printed, Path(last.strip())


def add_to_settings(block: str, path: Path) -> None:
    """Put commands below `[commands]`, as the lesson says."""
    head, lines = block.split("\n", 1)
    head = head.partition("  #")[0]
    settings = path.read_text()
    assert settings.count(f"{head}\n") == 1
    path.write_text(settings.replace(f"{head}\n", f"{head}\n{lines}"))


def test_each_step_does_what_the_lesson_says(tmp_path: Path) -> None:
    folder, printed, run = tmp_path, "", 0
    for language, block in blocks():
        if language == "sh":
            printed, folder = typed(block, folder)
            run += 1
        elif language == "text":
            at = 0
            for line in block.splitlines():
                assert line in printed[at:], printed
                at = printed.index(line, at)
        elif language == "toml":
            add_to_settings(block, folder / "voz.toml")
        elif language == "python":
            name = re.match(r"# (\w+\.py)\n", block)
            assert name
            (folder / name[1]).write_text(block)
    assert run > 8
    assert (tmp_path / "cart" / "my_robot.py").is_file()
