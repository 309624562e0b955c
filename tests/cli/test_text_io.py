"""Text from and to others: events, and names, lines and messages that are no plain text."""

from __future__ import annotations

import os
import shutil
import subprocess
from pathlib import Path
from typing import Any

import pytest
from calls import HANGS, VOZ
from recordings import GO_BACK, ROOT

from voz.cli.text_io import event_log
from voz.events import Twist


def test_each_event_is_on_the_disk_at_once(tmp_path: Path) -> None:
    path = tmp_path / "e.jsonl"
    with event_log(str(path)) as receive:
        for t in (0.1, 0.2):
            receive(Twist(t, 0.1, 0.0))
            assert path.read_text().count("\n") == round(10 * t)
    *_, last = path.read_text().splitlines()
    assert last == '{"type":"cmd_vel","t":0.2,"linear":0.1,"angular":0.0}'


@pytest.mark.parametrize("pace", [[], ["--realtime"]])
def test_a_full_disk_is_one_clear_line(pace: list[str], voz: Any, tmp_path: Path) -> None:
    typed = tmp_path / "typed.txt"
    typed.write_text("start speech\ngo forward\n-\n-\n")
    arguments = ["--text", typed, "--no-sound", "--events", "/dev/full"]
    result = voz("run", *arguments, *pace)
    assert result.complaint == "voz: /dev/full: cannot be written (No space left on device)"
    assert "drives" not in result.out


ESCAPES = "\x1b]0;owned\x07\x1b[2J\r\u202e"


def called(
    *arguments: str | bytes | Path, stdin: bytes = b"", **environment: str
) -> subprocess.CompletedProcess[bytes]:
    return subprocess.run(
        [*VOZ, *arguments],
        input=stdin,
        capture_output=True,
        timeout=HANGS,
        cwd=ROOT,
        env=os.environ | environment,
    )


def is_plain(shown: bytes) -> bool:
    return all(line.isprintable() for line in shown.decode().splitlines())


@pytest.mark.slow
@pytest.mark.parametrize(
    ("locale", "more"),
    [("C.UTF-8", []), ("POSIX", ["--events", "-"]), ("C", []), ("C", ["--realtime"])],
)
def test_a_bad_byte_in_typed_text_is_no_command_and_not_the_end(
    locale: str, more: list[str]
) -> None:
    typed = b"start speech\ngo \xff\xfe\n\xed\xb3\xbf\ngo forward\n\x00\nstop\n"
    done = called("run", "--text", "-", "--no-sound", *more, stdin=typed, LC_ALL=locale)
    assert done.returncode == 0
    shown = (done.stdout + done.stderr).decode()
    assert "Traceback" not in shown
    assert ("0.1" if more == ["--events", "-"] else "drives forward") in shown
    assert "stands still" in shown or '"linear":0.0' in shown.splitlines()[-1]


def test_file_names_cannot_write_on_the_terminal(tmp_path: Path) -> None:
    named = [tmp_path / name for name in (ESCAPES, "\udcff", "\n")]
    good, none = ([path.with_name(path.name + end) for path in named] for end in (".flac", ".wav"))
    for path in good:
        shutil.copy(GO_BACK, path)
    done = called("decode", *good, *none)
    assert is_plain(done.stdout + done.stderr)
    assert done.returncode == 3
    for paths, code in ((good, 0), (none, 3)):
        done = called("run", "--no-sound", *(each for path in paths for each in ("--wav", path)))
        assert is_plain(done.stdout + done.stderr)
        assert done.returncode == code


@pytest.mark.realtime
def test_typed_text_and_robots_cannot_write_on_the_terminal(tmp_path: Path) -> None:
    (tmp_path / "loud.py").write_text(
        "from voz.robot.base import Robot\n"
        "class Loud(Robot):\n"
        f"    def receive(self, event): raise OSError({ESCAPES!r})\n"
    )
    done = called(
        "run", "--text", "-", "--no-sound", "--robot", "console,loud:Loud",
        stdin=f"start speech\n{ESCAPES}\n".encode(), PYTHONPATH=_path(tmp_path),
    )  # fmt: skip
    assert done.returncode == 2
    assert rb"\x1b]0;owned" in done.stdout
    assert is_plain(done.stdout + done.stderr)


@pytest.mark.parametrize(
    "arguments",
    [
        [ESCAPES],
        ["decode", f"--{ESCAPES}", "a.wav"],
        ["decode", "--config", ESCAPES, "a.wav"],
        ["decode", "--profile", ESCAPES, GO_BACK],
        ["decode", "--profile", "\udcff", GO_BACK],
        ["eval", ESCAPES],
        ["run", "--no-sound", "--text", ESCAPES],
        ["run", "--no-sound", "--text", "-", "--robot", ESCAPES],
        ["run", "--no-sound", "--text", "-", "--robot", f"{ESCAPES}:{ESCAPES}"],
        ["run", "--no-sound", "--text", "-", "--events", f"none/{ESCAPES}"],
        ["say", ESCAPES, "--voice", ESCAPES],
        ["sound", ESCAPES],
        ["build-lm", ESCAPES],
    ],
)
def test_a_wrong_call_cannot_write_on_the_terminal(arguments: list[Any], voz: Any) -> None:
    done = voz(*arguments)
    assert done.out == ""
    assert is_plain(done.complaint.encode())


@pytest.mark.parametrize("name", ["my $(touch owned) robot", "a;b", "-x", "it's", ESCAPES])
def test_the_line_to_go_on_with_runs_nothing_but_itself(name: str, tmp_path: Path) -> None:
    done = subprocess.run([*VOZ, "new", "--", name], cwd=tmp_path, capture_output=True, text=True)
    assert done.returncode == 0
    assert is_plain((done.stdout + done.stderr).encode())
    line = done.stderr.splitlines()[-1].removeprefix("go on with: ").removesuffix("; voz run")
    there = subprocess.run(
        ["sh", "-c", f"{line}; pwd"], cwd=tmp_path, capture_output=True, text=True
    )
    assert [path.name for path in tmp_path.iterdir()] == [name]
    if name != ESCAPES:
        assert there.stdout == f"{tmp_path / name}\n"


def _path(folder: Path) -> str:
    return os.pathsep.join([str(folder), os.environ.get("PYTHONPATH", "")])
