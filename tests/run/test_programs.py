"""Programs and functions that commands start: they end, and hold nothing up."""

from __future__ import annotations

import queue
import signal
import sys
from pathlib import Path

import pytest
from programs import PATIENCE, is_alive, wait_until

from voz.config import Config
from voz.control.steps import Step
from voz.control.table import CommandTable
from voz.errors import ConfigError
from voz.events import CallFunction, ProgramEnded, StartProgram, Twist
from voz.run.programs import MAX_PROGRAM_LINE, MAX_PROGRAMS, Programs

NONE = Config().table


def ended(said: queue.Queue[ProgramEnded]) -> ProgramEnded:
    return said.get(timeout=PATIENCE)


def table(**commands: Step) -> CommandTable:
    return Config(commands=commands).table


def test_a_program_gets_its_arguments_as_they_are(tmp_path: Path) -> None:
    said: queue.Queue[ProgramEnded] = queue.Queue()
    with Programs(NONE, said.put, print) as programs:
        programs.receive(Twist(0, 0, 0))
        programs.receive(StartProgram(1, ("touch", f"{tmp_path}/a; rm b")))
        assert ended(said) == ProgramEnded(1, "touch")
    assert [path.name for path in tmp_path.iterdir()] == ["a; rm b"]


def test_one_that_fails_or_is_not_there_says_so() -> None:
    said: queue.Queue[ProgramEnded] = queue.Queue()
    with Programs(NONE, said.put, print) as programs:
        programs.receive(StartProgram(0, ("false",)))
        assert ended(said) == ProgramEnded(0, "false", "exit code 1")
        programs.receive(StartProgram(0, ("/no/such",)))
        assert "cannot be started" in ended(said).problem


def test_what_a_program_prints_is_shown_line_by_line_before_its_end_is_told() -> None:
    shown: queue.Queue[str | ProgramEnded] = queue.Queue()
    script = "echo one; printf 'two\\377\\n' >&2; sleep 3 & exit 3"
    with Programs(NONE, shown.put, shown.put) as programs:
        programs.receive(StartProgram(0, ("/bin/sh", "-c", script)))
        got = [shown.get(timeout=PATIENCE) for _ in range(3)]
    assert got == ["sh: one", r"sh: two\xff", ProgramEnded(0, "/bin/sh", "exit code 3")]


def test_what_a_program_prints_cannot_write_on_the_terminal() -> None:
    shown: queue.Queue[str] = queue.Queue()
    with Programs(NONE, lambda _: None, shown.put) as programs:
        programs.receive(
            StartProgram(0, ("printf", r"\033]0;owned\007\033[2J\033[1;31ma\tb\033[\007\n"))
        )
        assert shown.get(timeout=PATIENCE) == r"printf: a       b\x1b[\x07"


def test_a_program_whose_output_is_read_in_part_ends_without_a_word() -> None:
    shown: queue.Queue[str | ProgramEnded] = queue.Queue()
    # As ALSA's plugin for PulseAudio leaves it in a process that plays or records.
    before = signal.pthread_sigmask(signal.SIG_BLOCK, [signal.SIGPIPE])
    try:
        with Programs(NONE, shown.put, shown.put) as programs:
            programs.receive(StartProgram(0, ("/bin/sh", "-c", "yes | head -n 1")))
            got = [shown.get(timeout=PATIENCE) for _ in range(2)]
    finally:
        signal.pthread_sigmask(signal.SIG_SETMASK, before)
    assert got == ["sh: y", ProgramEnded(0, "/bin/sh")]


def test_a_line_without_an_end_comes_in_pieces() -> None:
    shown: queue.Queue[str] = queue.Queue()
    with Programs(NONE, lambda _: None, shown.put) as programs:
        programs.receive(StartProgram(0, ("sh", "-c", "cat /dev/zero | tr '\\0' x")))
        assert [shown.get(timeout=PATIENCE) for _ in range(3)] == [
            f"sh: {'x' * MAX_PROGRAM_LINE}"
        ] * 3


def test_one_that_hangs_is_ended_with_its_children(tmp_path: Path) -> None:
    said: queue.Queue[ProgramEnded] = queue.Queue()
    child = tmp_path / "child"
    script = f"sleep 600 & echo $! > {child}; wait"
    with Programs(NONE, said.put, print) as programs:
        programs.receive(StartProgram(0, ("sh", "-c", script), 0.5))
        assert ended(said) == ProgramEnded(0, "sh", "was ended after 0.5 s")
    wait_until(lambda: not is_alive(int(child.read_text())))


def test_the_end_of_the_run_ends_them(tmp_path: Path) -> None:
    child = tmp_path / "child"
    with Programs(NONE, lambda _: None, print) as programs:
        programs.receive(StartProgram(0, ("sh", "-c", f"echo $$ > {child}; exec sleep 600")))
        wait_until(lambda: child.exists() and child.read_text())
    wait_until(lambda: not is_alive(int(child.read_text())))


def test_too_many_are_not_started() -> None:
    said: queue.Queue[ProgramEnded] = queue.Queue()
    with Programs(NONE, said.put, print) as programs:
        for _ in range(MAX_PROGRAMS + 1):
            programs.receive(StartProgram(0, ("sleep", "600")))
        assert "not started" in ended(said).problem


def test_a_function_is_called_and_what_it_raises_is_told(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    (tmp_path / "gripper_of_a_test.py").write_text(
        "def close(thing, force):\n    if force > 2:\n        raise RuntimeError(thing)\n"
        "    if force < 0:\n        raise SystemExit(thing)\n"
    )
    monkeypatch.chdir(tmp_path)
    monkeypatch.syspath_prepend(tmp_path)
    monkeypatch.delitem(sys.modules, "gripper_of_a_test", raising=False)  # of an earlier try
    target = "gripper_of_a_test:close"
    said: queue.Queue[ProgramEnded] = queue.Queue()
    with Programs(table(grip=Step(call=(target, "{thing}", 1.0))), said.put, print) as programs:
        programs.receive(CallFunction(0, target, ("cup", 1.0)))
        assert ended(said) == ProgramEnded(0, target)
        programs.receive(CallFunction(0, target, ("cup", 3.0)))
        assert ended(said) == ProgramEnded(
            0, target, "RuntimeError: cup (gripper_of_a_test.py, line 3)"
        )
        programs.receive(CallFunction(0, target, ("cup", -1.0)))
        assert ended(said) == ProgramEnded(
            0, target, "SystemExit: cup (gripper_of_a_test.py, line 5)"
        )


def test_a_function_that_hangs_is_told() -> None:
    said: queue.Queue[ProgramEnded] = queue.Queue()
    with Programs(table(nap=Step(call=("time:sleep", 2.0))), said.put, print) as programs:
        programs.receive(CallFunction(0, "time:sleep", (2.0,), 0.1))
        assert ended(said) == ProgramEnded(0, "time:sleep", "has not ended after 0.1 s")


@pytest.mark.parametrize(
    ("step", "why"),
    [
        (Step(run=("no-such-program",)), '"a" runs no-such-program, and there is no such program'),
        (Step(call=("no_such_module:f",)), '"a" calls no_such_module:f, which cannot be imported'),
        (
            Step(call=("os:no_such_function",)),
            '"a" calls os:no_such_function, which cannot be imported',
        ),
        (Step(call=("os:name",)), '"a" calls os:name, which is no function'),
    ],
)
def test_what_is_not_there_is_told_before_anything_moves(step: Step, why: str) -> None:
    with pytest.raises(ConfigError) as caught:
        Programs(table(a=step), lambda _: None, print)
    assert why in str(caught.value)


def test_a_module_that_ends_the_program_is_told(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    (tmp_path / "ends_at_once.py").write_text("import sys\n\nsys.exit()\n")
    monkeypatch.chdir(tmp_path)
    with pytest.raises(ConfigError, match=r"imported \(SystemExit \(ends_at_once.py, line 3\)\)$"):
        Programs(table(grip=Step(call=("ends_at_once:close",))), lambda _: None, print)
