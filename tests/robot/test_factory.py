from __future__ import annotations

import io
import sys
import threading
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import Any

import pytest
from calls import in_process
from programs import PATIENCE, wait_until
from recordings import ROOT

from voz.config import Config, load_config
from voz.errors import ConfigError, RobotError
from voz.events import Event, Twist
from voz.robot.base import Robot
from voz.robot.console import ConsoleRobot
from voz.robot.factory import (
    ROBOTS,
    RobotSetup,
    make_robots,
    need_real_time,
    open_mailboxes,
    open_robots,
    robot_names,
)
from voz.robot.simulation.simulator import SimulatedRobot


def setup() -> RobotSetup:
    return RobotSetup(Config(), io.StringIO(), lambda _: None)


def test_names_are_given_one_by_one_or_with_commas_and_count_once() -> None:
    assert robot_names(["console,simulator", "ros1", " console "]) == [
        "console",
        "simulator",
        "ros1",
    ]


def test_an_unknown_name_is_told_with_those_that_are_known() -> None:
    with pytest.raises(ConfigError, match="no robot rso1; name one of console, simulator, ros1"):
        robot_names(["console,rso1"])


def test_only_the_console_and_the_simulator_go_without_a_clock() -> None:
    assert not need_real_time(["console", "simulator"])
    assert [name for name in ROBOTS if need_real_time([name])] == ["ros1", "ros2"]
    assert need_real_time(["console", "serial_robot:SerialRobot"])


def test_the_documents_and_the_help_tell_of_all_of_them() -> None:
    page = (ROOT / "docs" / "robots.md").read_text()
    readme = (ROOT / "README.md").read_text()
    told = " ".join(in_process("run", "--help").out.split())
    for name, kind in ROBOTS.items():
        assert f"| `{name}` | {kind.does} |" in page
        assert f"`{name}`" in readme
    assert f"{', '.join(ROBOTS)} or MODULE:CLASS" in told


def test_all_robots_are_told_where_a_simulated_one_is() -> None:
    made = make_robots(["console", "simulator"], setup())
    assert made["simulator"].where is None
    assert made["console"].where
    assert made["console"].where(0.0).pose.x == Config().simulator.start[0]
    assert make_robots(["console"], setup())["console"].where is None


def test_robots_are_made_by_their_names() -> None:
    made = make_robots(["console", "simulator"], setup())
    assert [type(robot) for robot in made.values()] == [ConsoleRobot, SimulatedRobot]


def test_a_robot_of_the_users_own_is_a_class_in_a_module_here(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    (tmp_path / "my_wheels.py").write_text(
        "from voz.robot.base import Robot\n\nclass Wheels(Robot):\n"
        "    def move(self, linear, angular): pass\n"
    )
    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr(sys, "path", [*sys.path])
    made = make_robots(["my_wheels:Wheels"], setup())
    assert isinstance(made["my_wheels:Wheels"], Robot)


WHEELS = """
from voz.robot.base import Robot

class Wheels(Robot):
    def __init__(self, port="/dev/ttyUSB0", baud=9600):
        self.settings = port, baud
    def open(self):
        print(*self.settings)
    def receive(self, event):
        pass

class Plain(Robot):
    pass
"""


MISSPELT = """
from voz.robot.base import Robot

class Empty(Robot): pass

class Mov(Robot):
    def mov(self, linear, angular): pass

class Moves(Mov):
    def on_stop(self): pass

class Recieve(Robot):
    def recieve(self, event): pass

class Comand(Robot):
    def comand(self, name, slots): pass

class Camel(Robot):
    def onMove(self, linear, angular): pass

class Later(Robot):
    def __init__(self):
        self.move = print

class Mixed(Later, Mov): pass
"""


@pytest.mark.parametrize(
    ("kind", "advice"),
    [
        ("Empty", "write the one that it needs"),
        ("Mov", "did you mean move?"),
        ("Moves", "did you mean move?"),
        ("Recieve", "did you mean receive?"),
        ("Comand", "did you mean command?"),
        ("Camel", "did you mean move?"),
        ("Later", None),
        ("Mixed", None),
    ],
)
def test_a_robot_that_would_do_nothing_is_refused_with_what_may_be_meant(
    kind: str, advice: str | None, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    (tmp_path / "misspelt.py").write_text(MISSPELT)
    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr(sys, "path", [*sys.path])
    monkeypatch.delitem(sys.modules, "misspelt", raising=False)
    if advice is None:
        assert make_robots([f"misspelt:{kind}"], setup())
        return
    with pytest.raises(RobotError) as raised:
        make_robots([f"misspelt:{kind}"], setup())
    assert str(raised.value) == f"{kind} has none of move, command, receive; {advice}"


@pytest.fixture
def wheels(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    (tmp_path / "own_wheels.py").write_text(WHEELS)
    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr(sys, "path", [*sys.path])
    monkeypatch.delitem(sys.modules, "own_wheels", raising=False)
    return tmp_path


@pytest.mark.parametrize("watchdog", [False, True])
def test_a_robot_of_the_users_own_has_settings_like_the_others(
    watchdog: bool, wheels: Path, capfd: pytest.CaptureFixture[str]
) -> None:
    (wheels / "voz.toml").write_text("[own.own_wheels]\nbaud = 115200\n[own.others]\na = 1\n")
    printed = io.StringIO()
    settings = load_config(wheels / "voz.toml")
    robots = make_robots(["own_wheels:Wheels"], RobotSetup(settings, printed, print, watchdog))
    with open_mailboxes(robots, print):
        wait_until(lambda: "/dev/ttyUSB0 115200" in printed.getvalue() + capfd.readouterr().out)


@pytest.mark.parametrize(
    ("kind", "table", "said"),
    [
        ("Wheels", {"prot": "/dev/ttyUSB1"}, "got an unexpected keyword argument 'prot'"),
        ("Plain", {"port": "/dev/ttyUSB1"}, "got an unexpected keyword argument 'port'"),
    ],
)
def test_settings_that_it_does_not_take_are_one_line(
    kind: str, table: dict[str, Any], said: str, wheels: Path
) -> None:
    given = replace(setup(), settings=Config(own={"own_wheels": table}))
    with pytest.raises(ConfigError, match=rf"^\[own.own_wheels\] .* the class {kind} \({said}\): "):
        make_robots([f"own_wheels:{kind}"], given)


@pytest.mark.parametrize("name", ["no_such_module:Robot", "voz.robot.base:Rowboat"])
def test_a_robot_that_cannot_be_imported_is_one_line(name: str) -> None:
    with pytest.raises(RobotError, match=f"^the robot {name} cannot be used here: [^\n]*$"):
        make_robots([name], setup())


@pytest.mark.parametrize("module", ["no_such_module", "own_wheels.py"])
def test_a_module_that_is_not_there_is_told_with_where_it_should_be(
    module: str, wheels: Path
) -> None:
    with pytest.raises(RobotError, match=rf"no module {module} in the folder .* without its \.py$"):
        make_robots([f"{module}:Wheels"], setup())


class Kept(Robot):
    def __init__(self, log: list[str], name: str, fails: bool = False) -> None:
        self._log, self._name, self._fails = log, name, fails

    def open(self) -> None:
        if self._fails:
            raise RobotError(f"{self._name} is not there")
        self._log.append(f"{self._name} opens")

    def receive(self, event: Event) -> None:
        self._log.append(f"{self._name} gets {event.t:g}")

    def close(self) -> None:
        self._log.append(f"{self._name} closes")


@pytest.mark.parametrize("how", [open_robots, lambda robots: open_mailboxes(robots, print)])
def test_if_one_cannot_be_opened_the_others_are_closed(how: Callable[..., object]) -> None:
    log: list[str] = []
    robots = {"a": Kept(log, "a"), "b": Kept(log, "b", fails=True)}
    with pytest.raises(RobotError, match="b is not there"), how(robots):  # type: ignore[attr-defined]
        raise AssertionError
    assert log == ["a opens", "a closes"]


def test_each_gets_the_last_event_before_it_is_closed() -> None:
    log: list[str] = []
    with open_mailboxes({"a": Kept(log, "a"), "b": Kept(log, "b")}, log.append) as boxes:
        for box in boxes.values():
            box.receive(Twist(7, 0, 0))
    for name in "ab":
        assert [line for line in log if line.startswith(name)] == [
            f"{name} opens",
            f"{name} gets 7",
            f"{name} closes",
        ]


def test_all_close_side_by_side() -> None:
    together = threading.Barrier(2, timeout=PATIENCE)
    hung: list[str] = []

    class Leaving(Kept):
        def close(self) -> None:
            together.wait()

    with open_mailboxes({"a": Leaving([], "a"), "b": Leaving([], "b")}, hung.append):
        pass
    assert not hung
    assert together.n_waiting == 0
