"""Robots of users with a mistake in them, before anything moves."""

from __future__ import annotations

import io
import signal
import sys
from pathlib import Path

import pytest

from voz.config import Config
from voz.errors import RobotError, SpeechError
from voz.robot.factory import make_robots, open_robots
from voz.robot.kinds import RobotSetup
from voz.robot.user_code import user_errors_as_mistake

ARM = "from voz.robot.base import Robot\n\nclass Arm(Robot):\n"

MOVE = "\n    def move(self, *_): pass"


def used(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, code: str, name: str = "my_arm:Arm"
) -> str:
    """What is said of a robot with this code when it is made and opened."""
    (tmp_path / "my_arm.py").write_text(code)
    (tmp_path / "my_helper.py").write_text("def port():\n    return {}['port']\n")
    (tmp_path / "my_typo.py").write_text("\n\ndef port(:\n")
    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr(sys, "path", [str(tmp_path), *sys.path])
    monkeypatch.setattr(sys, "dont_write_bytecode", True)
    for module in ("my_arm", "my_helper", "my_typo"):
        monkeypatch.delitem(sys.modules, module, raising=False)
    setup = RobotSetup(Config(), io.StringIO(), lambda _: None)
    with pytest.raises(RobotError) as raised, open_robots(make_robots([name], setup)):
        pass
    return str(raised.value)


@pytest.mark.parametrize(
    ("code", "told"),
    [
        ("class Arm(:\n", "SyntaxError: invalid syntax (my_arm.py, line 1)"),
        ("import my_typo\n", "SyntaxError: invalid syntax (my_typo.py, line 3)"),
        ("class Arm:\n\tpass\n    pass\n", "IndentationError: "),
        (
            "\nimport no_driver\n",
            "ModuleNotFoundError: No module named 'no_driver' (my_arm.py, line 2)",
        ),
        ("import my_helper\nmy_helper.port()\n", "KeyError: 'port' (my_helper.py, line 2)"),
        ("import json\njson.loads('{')\n", " (my_arm.py, line 2)"),
        ("import sys\nsys.exit(3)\n", "SystemExit: 3 (my_arm.py, line 2)"),
        ("raise SystemExit", "SystemExit (my_arm.py, line 1)"),
        ("raise KeyboardInterrupt", "KeyboardInterrupt (my_arm.py, line 1)"),
        ("Leg = 1", "AttributeError: module 'my_arm' has no attribute 'Arm'"),
        ("Arm = 1", "TypeError: 'int' object is not callable"),
        (ARM + "    def __init__(self, port): pass", "required positional argument: 'port'"),
        (ARM + "    def __init__(self): self.port", "has no attribute 'port' (my_arm.py, line 4)"),
        (ARM + "    def open(self): open('/dev/none')" + MOVE, " (my_arm.py, line 4)"),
        (ARM + "    def open(self): raise OSError('a\\nb')" + MOVE, ": a b (my_arm.py, line 4)"),
    ],
)  # fmt: skip
def test_a_mistake_is_one_line_with_its_place(
    code: str, told: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(signal, "getsignal", lambda _: None)  # as `voz` has its own handlers
    line = used(tmp_path, monkeypatch, code)
    assert line.startswith("the robot my_arm:Arm cannot be used here: ")
    assert told in line
    assert "\n" not in line


def test_what_is_no_robot_is_told_with_what_it_lacks(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    code = "class Arm:\n    def open(self): pass\n"
    line = used(tmp_path, monkeypatch, code)
    assert line == (
        "the robot my_arm:Arm has no receive(); derive its class from voz.robot.base.Robot"
    )


@pytest.mark.parametrize("name", [":Arm", "my_arm:", ".my_arm:Arm", "my_arm:Arm:Leg"])
def test_half_a_name_is_one_line(
    name: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    line = used(tmp_path, monkeypatch, "", name)
    assert line.startswith(f"the robot {name} cannot be used here: ")


def test_an_error_that_cannot_even_be_printed_is_named(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    code = "class Bad(Exception):\n    def __str__(self): return 1 / 0\n\nraise Bad\n"
    assert used(tmp_path, monkeypatch, code).endswith("here: Bad (my_arm.py, line 4)")


def test_what_a_robot_says_itself_stays_as_it_is() -> None:
    with pytest.raises(SpeechError, match=r"^it is hoarse$"), user_errors_as_mistake("parrot"):
        raise SpeechError("it is hoarse")


def test_ctrl_c_stays_ctrl_c_for_who_uses_voz_as_a_library() -> None:
    # A command line that ran in this process before has taken the signal.
    before = signal.signal(signal.SIGINT, signal.default_int_handler)
    try:
        with pytest.raises(KeyboardInterrupt), user_errors_as_mistake("parrot"):
            raise KeyboardInterrupt
    finally:
        signal.signal(signal.SIGINT, before)
