"""A user without a home folder, or with one that cannot be written."""

from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path

import pytest
from calls import HANGS
from recordings import GO_BACK, ROOT

NOBODY = """
import os, pwd, sys
def unknown(*_): raise KeyError("uid not found")
pwd.getpwuid = unknown  # as in a container that runs with a number for its user
os.environ.pop("HOME", None)
from voz.cli import main
sys.exit(main())
"""

KNOWN_USER = "import sys; from voz.cli import main; sys.exit(main())"


def called(code: str, *arguments: object, **environment: str) -> subprocess.CompletedProcess[str]:
    given = {k: v for k, v in os.environ.items() if not k.startswith(("XDG_", "MPL"))}
    return subprocess.run(
        [sys.executable, "-c", code, *map(str, arguments)],
        capture_output=True,
        text=True,
        timeout=HANGS,
        cwd=ROOT,
        env=given | environment,
    )


@pytest.mark.parametrize(
    "arguments",
    [
        ["decode", "--profile", "ana", GO_BACK],
        ["calibrate", "--list"],
        ["calibrate", "ana", "--delete"],
        ["calibrate", "ana", "--wav", "audio_fixtures"],
    ],
)
def test_what_needs_a_home_says_so_in_one_line(arguments: list[object]) -> None:
    done = called(NOBODY, *arguments)
    assert done.returncode == 2
    assert done.stderr == "voz: there is no home folder for profiles; set XDG_DATA_HOME\n"


WROTE = ("drawing ", "written: ")


CALLS = [
    ["run", "--wav", GO_BACK, "--no-sound", "--robot", "simulator", "--picture", "way.svg"],
    ["say", "hello", "--out", "hello.wav"],
    ["decode", GO_BACK],
    ["run", "--wav", GO_BACK],
    ["--help"],
    ["build-lm", "--check"],
    ["sound", "--list"],
]


@pytest.mark.slow
@pytest.mark.parametrize(
    ("code", "arguments"),
    [*((NOBODY, call) for call in CALLS), *((KNOWN_USER, call) for call in CALLS[:3])],
)
def test_all_else_works_without_a_word_about_it(
    code: str, arguments: list[object], tmp_path: Path
) -> None:
    files = ("way.svg", "hello.wav")
    arguments = [tmp_path / a if a in files else a for a in arguments]
    done = called(code, *arguments, HOME="/proc")  # not even root can write there
    assert done.returncode == 0
    news = [line for line in done.stderr.splitlines() if not line.startswith(WROTE)]
    assert news in ([], ["warning: there is no loudspeaker; connect one"])
