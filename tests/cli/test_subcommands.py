"""All subcommands: wrong calls, the help, and how fast it is there."""

from __future__ import annotations

import os
import re
import subprocess
import sys
from typing import Any

import pytest
import typer
from calls import in_process
from recordings import GO_BACK

from voz import __version__
from voz.cli.subcommands import app


@pytest.mark.parametrize(
    ("arguments", "said"),
    [
        (["decode"], "PATH"),
        (["decode", "--threshold", "much", GO_BACK], "--threshold"),
        (["decode", "--search", "magic", GO_BACK], "search"),
        (["decode", "--lm", "nowhere", GO_BACK], "voz build-lm"),
        (["decode", "--config", "none.toml", GO_BACK], "none.toml: cannot be read"),
        (["decode", "--nonsense", GO_BACK], "--nonsense"),
        (["nonsense"], "nonsense"),
        (["run", "--text", "-", "--wav", GO_BACK], "either"),
        (["run", "--text", "none.txt"], "none.txt: cannot be read"),
        (["run", "--text", "README.md", "--events", "none/e.jsonl"], "none/e.jsonl: cannot be"),
        (["eval", "none.tsv", "--jobs", "9" * 5000], "--jobs"),
        (["eval", "none.tsv", "--jobs", "9" * 20], "--jobs"),
        (["decode", "none.wav", "--time-limit", "nan"], "'--time-limit': nan is no number"),
        (["decode", "none.wav", "--time-limit", "inf"], "'--time-limit': inf is not in the range"),
        (["decode", "none.wav", "--time-limit", "1e300"], "--time-limit"),
        (["decode", "none.wav", "--memory-limit", "9" * 20], "'--memory-limit': 9999"),
        (["say"], "nothing to say"),
        (["say", "..."], "nothing to speak"),
        (["say", "hello", "--voice", "nobody"], "nobody"),
        (["build-lm", "none.txt"], "none.txt"),
        (["build-lm", "voz"], "voz: has no list"),
    ],
)
def test_a_wrong_call_is_one_line(arguments: list[object], said: str, voz: Any) -> None:
    assert said in voz(*arguments).complaint


def test_the_bare_command_shows_the_help(voz: Any) -> None:
    bare, asked = voz(), voz("--help")
    assert (bare.code, bare.out, bare.err) == (0, asked.out, "")
    assert bare.out.startswith("Usage: voz ")


def test_the_version_is_told(voz: Any) -> None:
    told = voz("--version")
    assert (told.code, told.out, told.err) == (0, f"voz {__version__}\n", "")


@pytest.mark.parametrize(
    "command",
    [
        "build-lm",
        "calibrate",
        "decode",
        "devices",
        "doctor",
        "eval",
        "fit-confidence",
        "merge",
        "run",
        "say",
        "sound",
    ],
)
def test_every_command_has_help_with_an_example(command: str, voz: Any) -> None:
    result = voz(command, "--help")
    assert result.code == 0
    assert re.search(f"Examples?: voz {command} ", " ".join(result.out.split()))


def test_each_example_of_a_help_has_a_line_of_its_own(voz: Any) -> None:
    lines = [line.strip() for line in voz("decode", "--help").out.splitlines()]
    examples = [line for line in lines if "Example:" in line]
    assert len(examples) == 2
    assert all(line.rindex("Example:") == 0 for line in examples)


@pytest.mark.parametrize("group", [(), ("service",), ("language",)])
@pytest.mark.parametrize("columns", [40, 80])
def test_the_help_lists_each_subcommand_with_its_whole_summary(
    group: tuple[str, ...], columns: int, monkeypatch: pytest.MonkeyPatch
) -> None:
    shown = in_process(*group, "--help", env=os.environ | {"COLUMNS": str(columns)}).out
    listed = "".join(shown.split("Commands:")[1].split())
    commands = typer.main.get_command(app)
    for name in group:
        commands = commands.commands[name]
    for name, command in commands.commands.items():
        summary = command.help.split("\n\n")[0]
        assert name + "".join(summary.split()) in listed


@pytest.mark.parametrize("asked", ["--help", "--version"])
def test_help_and_the_package_load_none_of_the_heavy_parts(asked: str) -> None:
    code = (
        "import sys, voz.cli\n"
        f"try: voz.cli.main([{asked!r}])\n"
        "except SystemExit: pass\n"
        "print([m for m in ('numpy', 'pocketsphinx', 'rich', 'soundfile', 'sounddevice', 'soxr')"
        " if m in sys.modules])"
    )
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert done.stdout.splitlines()[-1] == "[]"


def test_windows_is_told_in_one_line_where_voz_works() -> None:
    code = "import sys; sys.platform = 'win32'; from voz.cli import main; main()"
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True)
    told = "voz: needs Linux; on Windows use WSL 2, as docs/start.md says\n"
    assert (done.returncode, done.stdout, done.stderr) == (2, "", told)
