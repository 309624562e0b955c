"""The programs that README and docs/ show: their types are right, and README's robot drives."""

from __future__ import annotations

import os
import re
import subprocess
import sys
from pathlib import Path

import pytest
from calls import in_process
from documents import written
from recordings import ROOT

WITHOUT_TYPES = {"README.md", "README.es.md", "docs/lesson.md"}
"""Pages for beginners."""

LEFT_OUT = ("from dask_jobqueue", "qos = ")
"""How programs begin that need what is not installed here."""

MYPY = """\
[mypy]
strict = true
[mypy-voz.*]
follow_imports = silent
"""


def programs(folder: Path) -> list[Path]:
    """Write down the programs of each page, its blocks one below the other."""
    made = []
    for page in written():
        if str(page.path) in WITHOUT_TYPES:
            continue
        blocks = [b for b in page.blocks("python") if not b.startswith(LEFT_OUT)]
        for number, block in enumerate(own_files(blocks)):
            made.append(folder / f"{page.path.stem.replace('-', '_')}_{number}.py")
            made[-1].write_text(block, encoding="utf-8")
    return made


def own_files(blocks: list[str]) -> list[str]:
    """The blocks that begin with an import, each with those below that go on from there."""
    found: list[str] = []
    for block in blocks:
        if re.match(r"(# \w+\.py\n)?(import|from) ", block) or not found:
            found.append(block)
        else:
            found[-1] += f"\n\n{block}"
    return found


@pytest.mark.slow
def test_the_programs_of_the_documents_have_the_types_of_voz(tmp_path: Path) -> None:
    made = programs(tmp_path)
    assert len(made) > 4
    (tmp_path / "mypy.ini").write_text(MYPY)
    done = subprocess.run(
        [sys.executable, "-m", "mypy", *made],
        cwd=tmp_path,
        env=os.environ | {"MYPYPATH": str(ROOT)},
        capture_output=True,
        text=True,
    )
    assert done.returncode == 0, done.stdout


def test_the_robot_of_the_readme_prints_what_changes(tmp_path: Path) -> None:
    (page,) = (page for page in written() if page.path == Path("README.md"))
    (program,) = page.blocks("python")
    (tmp_path / "wheels.py").write_text(program, encoding="utf-8")
    typed = "\n".join(
        ["start speech", "go forward", *"-----", "turn left", *"-----", "stop", *"---"]
    )
    call = ("run", "--robot", "wheels:Wheels", "--no-sound", "--text", "-")
    run = in_process(*call, input=typed, cwd=tmp_path, env=os.environ | {"PYTHONPATH": str(ROOT)})
    printed = run.out.splitlines()
    assert printed == [
        "forward 0.1 m/s, to the left 0.0 rad/s",
        "forward 0.1 m/s, to the left 0.1 rad/s",
        "forward 0.0 m/s, to the left 0.0 rad/s",
    ]
