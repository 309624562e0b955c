"""`voz new`: what it makes works at once."""

from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path
from typing import Any

import pytest
from calls import in_process
from recordings import ROOT

from voz.apps.starter.robot_folder import ROBOT_TYPES, make_robot_folder
from voz.config import load_config
from voz.control.table import can_move
from voz.errors import ConfigError
from voz.language.language_files import LanguageFiles, read_commands
from voz.robot.factory import robot_names
from voz.run.command_check import check_list, mismatches


@pytest.mark.parametrize("robot_type", ROBOT_TYPES)
def test_each_command_does_something_and_one_stops(robot_type: str, tmp_path: Path) -> None:
    make_robot_folder(tmp_path / "robot", robot_type)
    settings = load_config(tmp_path / "robot" / "voz.toml")
    commands = read_commands(LanguageFiles(tmp_path / "robot" / "lm"))
    check_list(commands, settings.table, "commands.txt")
    assert list(mismatches(commands, settings, code_of_its_own=False)) == []
    assert any(can_move(settings.table, name) for name in commands.names)
    own = "my_robot:MyRobot"
    assert robot_names(settings.robot) == [robot_type if robot_type.startswith("ros") else own]


@pytest.mark.slow
@pytest.mark.parametrize("robot_type", ["serial", "ros2"])  # docs/lesson.md runs that of "python"
def test_its_own_test_passes_and_finds_what_is_missing(robot_type: str, tmp_path: Path) -> None:
    done = in_process("new", "robot", "--type", robot_type, cwd=tmp_path)
    assert done.code == 0, done.err
    assert all((tmp_path / line.split(":")[0]).is_file() for line in done.out.splitlines())
    assert own_test(tmp_path / "robot").endswith("OK\n")
    if robot_type == "ros2":
        settings = tmp_path / "robot" / "voz.toml"
        settings.write_text(settings.read_text().replace('"wave" =', '"nod" ='))
        assert "FAILED (failures=1)" in own_test(tmp_path / "robot")


def own_test(folder: Path) -> str:
    done = subprocess.run(
        [sys.executable, "-m", "unittest"],
        cwd=folder,
        env=os.environ | {"PYTHONPATH": str(ROOT)},
        capture_output=True,
        text=True,
    )
    assert "Ran 2 tests" in done.stderr
    return done.stderr


def test_what_is_there_is_not_replaced(voz: Any, tmp_path: Path) -> None:
    (tmp_path / "thesis.txt").write_text("all my work")
    done = voz("new", ".", cwd=tmp_path)
    assert done.complaint.endswith("is not empty; name a new folder")
    assert [path.name for path in tmp_path.iterdir()] == ["thesis.txt"]
    done = voz("new", "thesis.txt", cwd=tmp_path)
    assert done.complaint.startswith("voz: thesis.txt: ")
    with pytest.raises(ConfigError, match="--type arduino: give one of python, serial, "):
        make_robot_folder(tmp_path / "robot", "arduino")
    assert not (tmp_path / "robot").exists()
