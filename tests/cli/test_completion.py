"""Completion of commands and options, in a real bash."""

from __future__ import annotations

import os
import shlex
import subprocess
from pathlib import Path

import pytest
from calls import HANGS, VOZ

COMPLETED = r"""
{install}
COMP_WORDS=({words}) COMP_CWORD={last}
_voz_completion voz
echo "${{COMPREPLY[@]}}"
"""


@pytest.fixture
def environment(tmp_path: Path) -> dict[str, str]:
    """One in which bash finds `voz`, and a home folder of its own."""
    program = tmp_path / "bin" / "voz"
    program.parent.mkdir()
    program.write_text(f'#!/bin/sh\nexec {shlex.join(VOZ)} "$@"\n')
    program.chmod(0o755)
    return os.environ | {
        "HOME": str(tmp_path), "PATH": f"{program.parent}{os.pathsep}{os.environ['PATH']}"
    }  # fmt: skip


def bash(script: str, environment: dict[str, str]) -> str:
    done = subprocess.run(
        ["bash", "-c", script], env=environment, capture_output=True, text=True, timeout=HANGS
    )
    assert (done.returncode, done.stderr) == (0, "")
    return done.stdout


@pytest.mark.parametrize(
    ("words", "completed"),
    [
        ("voz de", ["decode", "devices"]),
        ("voz run --li", ["--listening", "--listen-ros"]),
        ("voz eval --compare", ["--compare"]),
    ],
)
def test_commands_and_options_are_completed(
    words: str, completed: list[str], environment: dict[str, str]
) -> None:
    last = len(words.split()) - 1
    install = 'eval "$(voz --show-completion)"'
    script = COMPLETED.format(install=install, words=words, last=last)
    assert bash(script, environment).split() == completed


def test_it_is_installed_for_every_later_shell(environment: dict[str, str]) -> None:
    told = bash("voz --install-completion; true", environment)
    assert told.startswith("bash completion installed in ")
    script = COMPLETED.format(install='. "$HOME/.bashrc"', words="voz cal", last=1)
    assert bash(script, environment).split() == ["calibrate"]


def test_completing_loads_none_of_the_heavy_parts(environment: dict[str, str]) -> None:
    *python, program = VOZ
    code = (
        "import atexit, sys\n"
        "heavy = ('numpy', 'pocketsphinx', 'rich', 'soundfile', 'sounddevice', 'soxr')\n"
        "atexit.register(lambda: print([m for m in heavy if m in sys.modules]))\n"
    )
    asked = {"_VOZ_COMPLETE": "complete_bash", "COMP_WORDS": "voz de", "COMP_CWORD": "1"}
    done = subprocess.run(
        [*python, code + program],
        env=environment | asked,
        capture_output=True,
        text=True,
        check=True,
    )
    assert done.stdout.split("\n")[:3] == ["decode", "devices", "[]"]
