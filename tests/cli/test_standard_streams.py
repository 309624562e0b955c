"""Standard input, output and errors that are closed, full or gone, for every subcommand."""

from __future__ import annotations

import shlex
import subprocess
from pathlib import Path

import pytest
from calls import HANGS, VOZ
from recordings import GO_BACK, ROOT

ALL_CLOSED = "<&- >&- 2>&-"

CALLS = [
    (["--help"], 0),
    (["nonsense"], 2),
    (["decode", GO_BACK], 0),
    (["decode", "--json", GO_BACK], 0),
    (["run", "--text", "-"], 0),
    (["run", "--wav", GO_BACK, "--events", "-", "--robot", "simulator"], 0),
    (["run", "--text", "-", "--realtime"], 0),
    (["build-lm", "--check"], 0),
    (["calibrate", "--list"], 0),
    (["sound", "--list"], 0),
    (["say"], 2),
    (["eval", "none.tsv", "--json", "-"], 2),
    (["fit-confidence", "none.tsv", "--out", "none.json"], 2),
]

ONE_CLOSED = [
    (">&-", ["--help"], 0),
    ("2>&-", ["say"], 2),
    ("<&-", ["run", "--text", "-"], 0),
    (">&-", ["decode", "--json", GO_BACK], 0),
    ("2>&-", ["decode", GO_BACK], 0),
    (">&-", ["run", "--wav", GO_BACK, "--robot", "simulator"], 0),
    ("2>&-", ["run", "--text", "-"], 0),
]


def called(redirection: str, arguments: list[object]) -> subprocess.CompletedProcess[str]:
    """Call the command from a shell, which can close its streams."""
    line = shlex.join([*VOZ, *map(str, arguments)])
    return subprocess.run(
        ["sh", "-c", f"{line} {redirection}"],
        capture_output=True,
        text=True,
        stdin=subprocess.DEVNULL,
        cwd=ROOT,
        timeout=HANGS,
    )


@pytest.mark.parametrize(
    ("redirection", "arguments", "code"),
    [*ONE_CLOSED, *((ALL_CLOSED, *call) for call in CALLS)],
)
def test_what_the_caller_closed_is_no_reason_to_fail(
    redirection: str, arguments: list[object], code: int
) -> None:
    done = called(redirection, arguments)
    assert done.returncode == code
    assert len(done.stderr.splitlines()) <= (code == 2)


@pytest.mark.slow
def test_what_is_opened_later_is_not_written_over_by_what_is_printed(tmp_path: Path) -> None:
    events, bag = tmp_path / "events.jsonl", tmp_path / "run.mcap"
    whole = tmp_path / "whole.jsonl"
    called("", ["run", "--wav", GO_BACK, "--events", whole])
    called(ALL_CLOSED, ["run", "--wav", GO_BACK, "--events", events, "--bag", bag])
    assert events.read_text() == whole.read_text()
    assert called("", ["run", "--replay", bag]).returncode == 0


@pytest.mark.parametrize(
    ("redirection", "arguments"),
    [
        (">/dev/full", ["sound", "--list"]),
        (">/dev/full", ["decode", GO_BACK]),
        (">/dev/full", ["decode", "--json", GO_BACK]),
        ("</dev/null >&0", ["decode", GO_BACK]),
    ],
)
def test_what_cannot_be_written_is_one_line(redirection: str, arguments: list[object]) -> None:
    done = called(redirection, arguments)
    assert done.returncode == 2
    (line,) = done.stderr.splitlines()
    assert "cannot be written" in line


def test_nobody_has_to_read_what_goes_wrong() -> None:
    done = called("2>/dev/full", ["decode", "none.wav", GO_BACK])
    assert done.returncode == 3
    assert "go back" in done.stdout
