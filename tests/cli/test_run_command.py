"""`voz run`: the events of recordings and typed commands, and how it ends."""

from __future__ import annotations

import json
import os
import re
import signal
import subprocess
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import soundfile
from calls import HANGS, VOZ, Result, in_process
from recordings import GO_BACK, ROOT, Recording
from synthesis import phrase, with_floor

from voz.audio import SAMPLE_RATE


@pytest.mark.slow
def test_run_writes_the_same_events_each_time(voz: Any, session: Recording, tmp_path: Path) -> None:
    logs = []
    for name in ("a.jsonl", "b.jsonl"):
        result = voz("run", "--wav", session.path, "--no-sound", "--events", tmp_path / name)
        assert result.code == 0
        logs.append((tmp_path / name).read_text())
    assert logs[0] == logs[1]
    last = json.loads(logs[0].splitlines()[-1])
    assert (last["type"], last["linear"], last["angular"]) == ("cmd_vel", 0, 0)


def test_events_on_standard_output_are_nothing_else(voz: Any, tmp_path: Path) -> None:
    (tmp_path / "typed.txt").write_text("start speech\ngo forward\n-\nstop\n")
    result = voz("run", "--text", tmp_path / "typed.txt", "--events", "-", "--no-sound")
    moves = [event["linear"] for event in result.json if event["type"] == "cmd_vel"]
    assert moves == [0, 0.1, 0.1, 0, 0]
    assert "drives forward at 0.10 m/s" in result.err


@pytest.mark.parametrize(
    ("robot", "told"),
    [
        ("console", 'no line of [commands] in voz.toml says what to do at "open gripper"\n'),
        ("my_robot:Lamp", ""),
    ],
)
def test_what_does_nothing_is_told(
    voz: Any, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, robot: str, told: str
) -> None:
    monkeypatch.syspath_prepend(ROOT / "examples")
    commands = tmp_path / "list.txt"
    commands.write_text("start speech\nstop\nopen gripper\n")
    assert voz("build-lm", commands, "--out", tmp_path).code == 0
    (tmp_path / "typed.txt").write_text("stop\n")
    result = voz(
        "run", "--text", tmp_path / "typed.txt", "--lm", tmp_path, "--robot", robot, "--no-sound"
    )
    assert (result.code, result.err) == (0, told)


def test_what_the_table_has_and_nobody_can_say_is_told(voz: Any, here: Path) -> None:
    own = '[commands]\nb.say = "b"\nstop = { stop = true }\n'
    Path("voz.toml").write_text(f'{own}[states.menu]\nc.say = "c"\nb.say = "b"\nd.say = "d"\n')
    result = voz("run", "--text", "-", "--no-sound", typed="stop\n")
    told = 'no line of the list of commands is "b" or "c" or 1 more: add it, and run `voz build'
    assert told in result.err


@pytest.mark.parametrize(
    ("line", "key"),
    [("Open Gripper", "Open Gripper"), ("open gripper", " Open  gripper!"), ("go two", "Go 2")],
)
def test_names_in_voz_toml_are_read_as_typed_text_is(
    voz: Any, here: Path, line: str, key: str
) -> None:
    Path("list.txt").write_text(f"{line}\nSTOP\n", "utf-8")
    Path("voz.toml").write_text(f'[commands]\n"{key}" = {{ say = "done" }}\n', "utf-8")
    assert voz("build-lm", "list.txt", "--out", "lm").code == 0
    typed = f"{line}\n-\n"
    result = voz("run", "--text", "-", "--no-sound", "--listening", typed=typed)
    assert (result.code, result.err.count("add it")) == (0, 0), result.err
    assert 'robot says "done"' in result.out


def test_who_types_help_reads_what_may_be_said(voz: Any) -> None:
    result = voz("run", "--text", "-", "--no-sound", typed="help\nstart speech\n?\n")
    asleep, awake = re.findall("you can say: (.*)", result.out)
    assert asleep == "start speech, stop speech, stop"
    assert awake.startswith("stop speech, go forward, go back, ")
    assert awake.endswith(" and 1 more")


def test_who_asks_aloud_what_it_can_do_hears_three_commands_of_the_list(
    voz: Any, here: Path
) -> None:
    own = "stop\ngo forward\nturn left\ndance\nhelp: what can you do\ngo back\n"
    Path("list.txt").write_text(own)
    Path("voz.toml").write_text(
        '[recognition]\nname = "hey robot"\n[commands]\ndance.say = "hop"\n'
    )
    assert voz("build-lm", "list.txt", "--out", "lm").code == 0
    said = phrase("festival_slt", "hey robot what can you do")
    soundfile.write("said.wav", with_floor(said, np.random.default_rng(0)), SAMPLE_RATE)
    result = voz("run", "--wav", "said.wav", "--no-sound", "--listening")
    assert 'robot says "you can say go forward, turn left or dance"' in result.out


def test_who_is_not_listened_to_is_told_the_words_of_the_list(voz: Any, here: Path) -> None:
    Path("list.txt").write_text("wake: hello robot [please]\nstop\ngo back\n")
    Path("voz.toml").write_text('[commands]\nwake = { listen = true, say = "hi" }\n')
    assert voz("build-lm", "list.txt", "--out", "lm").code == 0
    result = voz("run", "--text", "-", "--no-sound", typed="go back\nhello robot\ngo back\n")
    assert 'ignored  "go back" (1.00), not obeyed: say "hello robot" first' in result.out
    assert 'heard    "go back" (1.00)' in result.out


def test_a_command_that_is_defined_twice_is_refused(voz: Any, here: Path) -> None:
    twice = '[commands]\n"go back" = { drive = -0.2 }\n"Go Back" = { drive = -0.1 }\n'
    Path("voz.toml").write_text(twice)
    result = voz("run", "--text", "-", "--no-sound", typed="stop\n")
    assert result.code == 2
    assert 'voz.toml:3: "Go Back" is "go back", which is there twice; remove one' in result.err


def test_a_command_that_must_not_be_missed_and_is_in_no_list_is_named(voz: Any, here: Path) -> None:
    Path("voz.toml").write_text('[recognition]\nnever_missed = ["stop", "go forward", "stopp"]\n')
    result = voz("run", "--text", "-", "--no-sound", typed="stop\n")
    assert 'no line of the list of commands is "stopp": add it' in result.err
    assert "go forward" not in result.err


def test_without_safety_the_bare_rules_hold(voz: Any, tmp_path: Path) -> None:
    (tmp_path / "typed.txt").write_text("start speech\nrotate left\nstop\nslow down\n")
    arguments = ["run", "--text", tmp_path / "typed.txt", "--events", "-", "--no-sound"]

    def last_turn(result: Result) -> float:
        return [e["angular"] for e in result.json if e["type"] == "cmd_vel"][-2]

    assert last_turn(voz(*arguments)) == 0
    assert last_turn(voz(*arguments, "--no-safety")) == 0.05


def test_recordings_that_cannot_be_read_are_warnings_and_the_exit_code_3(voz: Any) -> None:
    result = voz("run", "--wav", "none.wav", GO_BACK, "--events", "-", "--no-sound")
    assert result.code == 3
    kinds = [event["type"] for event in result.json if event["type"] != "cmd_vel"]
    assert kinds == ["warning", "utterance"]


def test_verbose_names_the_language_files_that_are_used(
    own_commands: Path, voz: Any, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    (tmp_path / "typed.txt").write_text("stop\n")
    arguments = ["run", "-v", "--no-sound", "--text", tmp_path / "typed.txt"]
    voz("build-lm", own_commands)
    monkeypatch.chdir(tmp_path)
    assert f"language files: {own_commands.parent}" in voz(*arguments).err
    monkeypatch.chdir(tmp_path.parent)
    elsewhere = voz(*arguments).err
    assert "language files: " in elsewhere
    assert str(own_commands.parent) not in elsewhere


def test_without_festival_there_is_one_warning_and_everything_else_works(tmp_path: Path) -> None:
    typed = "start speech\nstop speech\nstart speech\ngo back\n"
    environment = os.environ | {"PATH": str(tmp_path), "XDG_CACHE_HOME": str(tmp_path)}
    result = in_process("run", "--text", "-", "--events", "-", input=typed, env=environment)
    assert result.code == 0
    (warning,) = [event["text"] for event in result.json if event["type"] == "warning"]
    assert "sudo apt-get install festival" in warning
    assert [e["linear"] for e in result.json if e["type"] == "cmd_vel"] == [0, 0, 0, -0.1, 0]


def test_a_reader_that_goes_away_is_no_error() -> None:
    command = subprocess.list2cmdline(VOZ[:1])
    run = f"{command} -c '{VOZ[2]}' run --text - --events - --no-sound 2>/dev/null"
    script = f"{run} | head -1; exit $PIPESTATUS"
    typed = "start speech\n" * 5000
    done = subprocess.run(
        ["bash", "-c", script], input=typed, capture_output=True, text=True, timeout=HANGS
    )
    assert len(done.stdout.splitlines()) == 1
    assert done.stderr == ""
    assert done.returncode == 128 + signal.SIGPIPE


@pytest.mark.parametrize(
    ("text", "said"),
    [
        ("/dev/zero", "/dev/zero: has a line without an end; write a command a line"),
        ("/proc/self/mem", "/proc/self/mem: cannot be read (Input/output error)"),
        ("/", "/: cannot be read (Is a directory)"),
    ],
)
def test_a_text_that_cannot_be_read_is_one_line(text: str, said: str, voz: Any) -> None:
    assert voz("run", "--no-sound", "--text", text).complaint == f"voz: {said}"
