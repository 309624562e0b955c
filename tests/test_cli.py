"""The `voz` command as a user calls it: what it prints, and its exit codes."""

from __future__ import annotations

import json
import os
import shutil
import signal
import subprocess
import sys
import threading
from pathlib import Path
from typing import Any

import pytest
import soundfile
from recordings import FIXTURES, ROOT, Recording

from voz.cli import main

VOZ = [sys.executable, "-c", "import sys; from voz.cli import main; sys.exit(main())"]
GO_BACK = FIXTURES / "commands" / "festival_slt__go_back.flac"


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


@pytest.fixture
def voz(capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch) -> Any:
    """Call the command in this process: ten times faster than in one of its own."""
    monkeypatch.setattr(signal, "signal", lambda *_: None)  # pytest's own stay
    monkeypatch.chdir(ROOT)

    def call(*arguments: object) -> Result:
        capsys.readouterr()
        code = main([str(argument) for argument in arguments])
        return Result(code, *capsys.readouterr())

    return call


def in_process(*arguments: object, **options: Any) -> Result:
    command = [*VOZ, *map(str, arguments)]
    done = subprocess.run(command, capture_output=True, text=True, timeout=60, **options)
    return Result(done.returncode, done.stdout, done.stderr)


# decode


def test_decode_writes_a_line_of_json_for_each_utterance(voz: Any, session: Recording) -> None:
    result = voz("decode", "--json", session.path, GO_BACK)
    assert result.code == 0
    assert [line["text"] for line in result.json] == [*session.commands, "go back"]
    assert {tuple(line) for line in result.json} == {
        ("file", "start", "end", "text", "confidence", "accepted")
    }
    assert result.json[-1]["file"] == str(GO_BACK)


def test_decode_shows_a_table(voz: Any) -> None:
    header, row = voz("decode", GO_BACK).out.splitlines()
    assert header.split() == ["start", "end", "sure", "obeyed", "text", "file"]
    assert row.split()[3:] == ["yes", "go", "back", str(GO_BACK)]


def test_an_unreadable_recording_is_a_line_and_the_exit_code_3(voz: Any, tmp_path: Path) -> None:
    (tmp_path / "bad.wav").write_text("no recording")
    result = voz("decode", "--json", tmp_path / "bad.wav", GO_BACK, tmp_path / "none.wav")
    assert result.code == 3
    assert [tuple(line)[:2] for line in result.json] == [
        ("file", "error"),
        ("file", "start"),
        ("file", "error"),
    ]


def test_silence_is_no_utterance_and_no_error(voz: Any, tmp_path: Path) -> None:
    soundfile.write(tmp_path / "silence.wav", [0.0] * 16000, 16000)
    result = voz("decode", "--json", tmp_path / "silence.wav")
    assert (result.code, result.out, result.err) == (0, "", "")


def test_a_threshold_and_the_trigram_model_can_be_chosen(voz: Any) -> None:
    (strict,) = voz("decode", "--json", "--threshold", "1", GO_BACK).json
    assert not strict["accepted"]
    (trigram,) = voz("decode", "--json", "--search", "lm", GO_BACK).json
    assert trigram["text"] == "go back"


def test_a_file_name_that_is_no_utf_8(tmp_path: Path) -> None:
    odd = os.fsdecode(os.fsencode(tmp_path) + b"/caf\xe9.flac")
    shutil.copy(GO_BACK, odd)
    result = in_process("decode", "--json", odd)
    assert result.code == 0
    assert result.json[0]["file"].endswith("caf\\xe9.flac")


@pytest.mark.parametrize(
    ("arguments", "said"),
    [
        (["decode"], "FILE"),
        (["decode", "--threshold", "2", GO_BACK], "threshold"),
        (["decode", "--threshold", "nan", GO_BACK], "threshold"),
        (["decode", "--threshold", "much", GO_BACK], "--threshold"),
        (["decode", "--search", "magic", GO_BACK], "search"),
        (["decode", "--lm", "nowhere", GO_BACK], "voz build-lm"),
        (["decode", "--config", "none.toml", GO_BACK], "none.toml: cannot be read"),
        (["decode", "--nonsense", GO_BACK], "--nonsense"),
        (["nonsense"], "nonsense"),
        (["run"], "--wav"),
        (["run", "--text", "-", "--wav", GO_BACK], "either"),
        (["run", "--text", "none.txt"], "none.txt: cannot be read"),
        (["run", "--text", "README.md", "--events", "none/e.jsonl"], "none/e.jsonl: cannot be"),
        (["say"], "nothing to say"),
        (["say", "..."], "nothing to speak"),
        (["say", "hello", "--voice", "nobody"], "nobody"),
        (["build-lm", "none.txt"], "none.txt"),
        (["build-lm", "lm"], "lm"),
    ],
)
def test_a_wrong_call_is_one_line(arguments: list[object], said: str, voz: Any) -> None:
    assert said in voz(*arguments).complaint


# build-lm


@pytest.fixture
def own_commands(tmp_path: Path) -> Path:
    path = tmp_path / "lm" / "comandos_voz.txt"
    path.parent.mkdir()
    path.write_text("# for my arm\nOpen Gripper\r\ngo back\n")
    return path


def test_own_commands_are_built_and_understood(
    voz: Any, own_commands: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    result = voz("build-lm")
    assert result.code == 0
    assert "2 sentences, 4 words" in result.out
    wav = tmp_path / "gripper.wav"
    assert voz("say", "open gripper", "--out", wav).code == 0
    (heard,) = voz("decode", "--json", wav).json
    assert (heard["text"], heard["accepted"]) == ("open gripper", True)


def test_check_names_the_stale_files(voz: Any, own_commands: Path) -> None:
    folder = own_commands.parent
    assert voz("build-lm", own_commands).code == 0
    assert voz("build-lm", own_commands, "--check").code == 0
    (folder / "comandos_voz.dic").write_text("go G OW\n")
    result = voz("build-lm", own_commands, "--check")
    assert result.code == 1
    assert "comandos_voz.dic" in result.err
    assert "comandos_voz.lm" not in result.err


def test_the_tool_does_the_same(voz: Any, own_commands: Path, tmp_path: Path) -> None:
    assert voz("build-lm", own_commands, "--out", tmp_path / "a").code == 0
    tool = [sys.executable, ROOT / "tools" / "build_lm.py", own_commands, "--out", tmp_path / "b"]
    subprocess.run(tool, check=True, capture_output=True)
    names = sorted(path.name for path in (tmp_path / "a").iterdir())
    assert len(names) == 6
    for name in names:
        assert (tmp_path / "a" / name).read_bytes() == (tmp_path / "b" / name).read_bytes()


def test_the_language_files_of_the_checkout_are_what_its_list_gives(voz: Any) -> None:
    assert voz("build-lm", "--check").code == 0


def test_a_list_that_changed_since_it_was_built_is_said(
    voz: Any, own_commands: Path, tmp_path: Path
) -> None:
    voz("build-lm", own_commands)
    own_commands.write_text("go back\nstop\n")
    result = voz("decode", "--lm", own_commands.parent, GO_BACK)
    assert result.code == 0
    assert "run it again" in result.err


# run


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


def test_typed_text_is_read_from_standard_input() -> None:
    result = in_process("run", "--text", "-", "--no-sound", input="start speech\ngo back\n")
    assert result.code == 0
    assert "drives back at 0.10 m/s" in result.out


def test_typed_text_that_is_no_text_is_no_command(voz: Any, tmp_path: Path) -> None:
    (tmp_path / "typed.txt").write_bytes(b"\xff\xfe\x00\n" * 3 + b"stop\n")
    result = voz("run", "--text", tmp_path / "typed.txt", "--events", "-", "--no-sound")
    heard = [event["accepted"] for event in result.json if event["type"] == "utterance"]
    assert heard == [False, False, False, True]


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


def signals_as_a_terminal_has_them() -> None:
    signal.signal(signal.SIGHUP, signal.SIG_DFL)


@pytest.mark.parametrize(
    ("number", "code"), [(signal.SIGTERM, 143), (signal.SIGHUP, 129), (signal.SIGINT, 130)]
)
def test_s7_a_signal_ends_with_zero_velocity(number: int, code: int) -> None:
    with subprocess.Popen(
        [*VOZ, "run", "--text", "-", "--events", "-", "--no-sound"],
        stdin=subprocess.PIPE,
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
        preexec_fn=signals_as_a_terminal_has_them,
    ) as process:
        deadline = threading.Timer(30, process.kill)
        deadline.start()
        assert process.stdin
        assert process.stdout
        assert process.stderr
        process.stdin.write("start speech\ngo forward\n")
        process.stdin.flush()
        assert any('"linear":0.1' in line for line in iter(process.stdout.readline, ""))
        process.send_signal(number)
        *_, last = process.stdout.read().splitlines()
        assert "Traceback" not in process.stderr.read()
        deadline.cancel()
    assert process.returncode == code
    assert json.loads(last)["linear"] == 0


def test_a_reader_that_goes_away_is_no_error() -> None:
    command = subprocess.list2cmdline(VOZ[:1])
    script = f"{command} -c '{VOZ[2]}' run --text - --events - --no-sound 2>/dev/null | head -1"
    typed = "start speech\n" * 5000
    done = subprocess.run(
        ["bash", "-c", script], input=typed, capture_output=True, text=True, timeout=60
    )
    assert len(done.stdout.splitlines()) == 1
    assert done.stderr == ""


# say


def test_say_writes_a_wav(voz: Any, tmp_path: Path) -> None:
    assert voz("say", "hello robot", "--out", tmp_path / "hello.wav").code == 0
    assert soundfile.info(tmp_path / "hello.wav").duration > 0.4


def test_say_lists_the_voices_that_are_installed(voz: Any) -> None:
    assert "kal_diphone" in voz("say", "--list-voices").out.splitlines()


# help and start


@pytest.mark.parametrize(
    "command", ["build-lm", "calibrate", "decode", "eval", "fit-confidence", "run", "say"]
)
def test_every_command_has_help_with_an_example(command: str, voz: Any) -> None:
    result = voz(command, "--help")
    assert result.code == 0
    assert f"Example: voz {command} " in " ".join(result.out.split())


def test_help_and_the_package_load_none_of_the_heavy_parts() -> None:
    code = (
        "import sys, voz.cli\n"
        "try: voz.cli.main(['--help'])\n"
        "except SystemExit: pass\n"
        "print([m for m in ('numpy', 'pocketsphinx', 'rich', 'soundfile', 'sounddevice', 'soxr')"
        " if m in sys.modules])"
    )
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert done.stdout.splitlines()[-1] == "[]"
