"""The steps of docs/lesson.md, one after the other, as its reader types them."""

from __future__ import annotations

import os
import re
import shutil
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path

import pytest
from documents import BLOCK
from live_terminal import Terminal
from programs import wait_until
from recordings import ROOT

pytestmark = pytest.mark.slow

HERE = "the lesson is in "


def blocks() -> Iterator[tuple[str, str]]:
    """The blocks of the lesson: language and text."""
    text = (ROOT / "docs" / "lesson.md").read_text(encoding="utf-8")
    yield from ((found[2], found[3]) for found in BLOCK.finditer(text))


def typed(block: str, folder: Path) -> tuple[str, Path]:
    """What commands print that are typed in a folder, and the folder that they end in."""
    path = f"{Path(sys.executable).parent}:{os.environ['PATH']}"
    done = subprocess.run(
        ["sh", "-e"],
        input=f"{block}echo '{HERE}'$PWD\n",
        cwd=folder,
        env=os.environ | {"PATH": path, "PYTHONPATH": str(ROOT)},
        stdout=subprocess.PIPE,
        stderr=subprocess.STDOUT,
        text=True,
    )
    assert done.returncode == 0, done.stdout
    printed, _, last = done.stdout.rpartition(HERE)
    return printed, Path(last.strip())


def add_to_settings(block: str, path: Path) -> None:
    """Put commands below `[commands]`, as the lesson says."""
    head, lines = block.split("\n", 1)
    head = head.partition("  #")[0]
    settings = path.read_text()
    assert settings.count(f"{head}\n") == 1
    path.write_text(settings.replace(f"{head}\n", f"{head}\n{lines}"))


@pytest.fixture(scope="module")
def followed(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The folder in which somebody has typed all that the lesson shows, and seen what it says."""
    start = tmp_path_factory.mktemp("lesson")
    folder, printed, run = start, "", 0
    for language, block in blocks():
        if language == "sh":
            printed, folder = typed(block, folder)
            run += 1
        elif language == "text":
            at = 0
            for line in block.splitlines():
                assert line in printed[at:], printed
                at = printed.index(line, at)
        elif language == "toml":
            add_to_settings(block, folder / "voz.toml")
        elif language == "python":
            name = re.match(r"# (\w+\.py)\n", block)
            assert name
            (folder / name[1]).write_text(block)
    assert run > 8
    return start


@pytest.fixture
def robot(followed: Path, tmp_path: Path) -> Path:
    """The robot of the lesson, of which a test may spoil what it likes."""
    return shutil.copytree(followed / "robot", tmp_path / "robot")


def test_each_step_does_what_the_lesson_says(followed: Path) -> None:
    assert (followed / "cart" / "my_robot.py").is_file()


def test_all_tests_of_the_robot_pass_at_the_end(robot: Path) -> None:
    printed, _ = typed("python -m unittest\n", robot)
    assert "Ran 3 tests" in printed
    printed, _ = typed("voz commands --card\n", robot)
    assert "metres" in (robot / "commands.html").read_text("utf-8")


def test_the_near_miss_is_ignored(tmp_path: Path) -> None:
    said = "voz say 'speak up' --out up.wav\nvoz run --no-sound --listening --wav up.wav\n"
    printed, _ = typed(said, tmp_path)
    assert 'ignored  "' in printed
    assert "robot drives" not in printed


def test_an_error_in_the_class_is_one_line_with_its_place(robot: Path) -> None:
    code = (robot / "my_robot.py").read_text()
    (robot / "my_robot.py").write_text(code.replace('print("the arm waves")', "1 / 0"))
    lines = (robot / "my_robot.py").read_text().splitlines()
    (place,) = (number for number, line in enumerate(lines, 1) if "1 / 0" in line)
    said = "printf 'start speech\\ngo forward\\nwave\\n-\\n-\\n'"
    printed, _ = typed(f"{said} | voz run --no-sound --text - || true\n", robot)
    assert f"division by zero (my_robot.py, line {place})): the robot stops" in printed
    assert "forward 0.00 m/s" in printed
    assert "Traceback" not in printed


@pytest.mark.realtime
def test_what_is_saved_with_a_mistake_is_refused_while_it_runs(
    robot: Path, pulse: dict[str, str]
) -> None:
    settings, commands = robot / "voz.toml", robot / "commands.txt"
    before = settings.read_text(), commands.read_text()
    terminal = Terminal(pulse | {"PYTHONPATH": str(ROOT)}, robot)

    def told(what: str) -> bool:
        terminal.look()
        return any(what in str(event.get("text", "")) for event in terminal.events())

    try:
        terminal.wait_for_velocity(0.0)
        settings.write_text(before[0].replace("{ rotate = -0.5", "{ rotte = -0.5"))
        wait_until(lambda: told("did you mean `rotate`?"))
        settings.write_text(before[0])
        commands.write_text(before[1].replace("\nstop\n", "\n"))
        wait_until(lambda: told("no command that stops it"))
        commands.write_text(before[1] + "jump\n")
        wait_until(lambda: told('new "jump"'))
        terminal.type("\x03")
        assert terminal.end() == 130
    finally:
        terminal.close()
