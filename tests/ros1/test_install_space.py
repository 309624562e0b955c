"""The package as catkin installs it, apart from the clone: what is there is found, and runs."""

from __future__ import annotations

import shutil
import subprocess
from collections.abc import Iterator
from pathlib import Path

import pytest
from recordings import ROOT
from ros1.ros import Ros, eventually, running_ros

pytestmark = pytest.mark.slow


@pytest.fixture(scope="module")
def share(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The folder `share/voz` of an install space."""
    folder = tmp_path_factory.mktemp("catkin")
    (folder / "build").mkdir()
    options = {
        "CMAKE_INSTALL_PREFIX": folder / "install",
        "CATKIN_DEVEL_PREFIX": folder / "devel",
        "PYTHON_EXECUTABLE": "/usr/bin/python3",  # that of Debian's ROS 1
    }
    named = [f"-D{name}={value}" for name, value in options.items()]
    for command in (["cmake", str(ROOT / "ros"), *named], ["make", "install"]):
        done = subprocess.run(command, cwd=folder / "build", capture_output=True, text=True)
        assert done.returncode == 0, done.stdout + done.stderr
    return folder / "install" / "share" / "voz"


@pytest.fixture
def ros(share: Path, tmp_path: Path, pulse: dict[str, str]) -> Iterator[Ros]:
    """A ROS that knows the install space alone."""
    environment = pulse | {"ROS_PACKAGE_PATH": str(share.parent)}
    with running_ros(tmp_path, **environment) as ros:
        yield ros


def test_launch_files_and_programs_are_there_and_nothing_of_ros_2(share: Path) -> None:
    there = {str(p.relative_to(share)) for p in share.rglob("*") if p.is_file()}
    source = ROOT / "ros"
    assert {f"scripts/{p.name}" for p in (source / "scripts").iterdir()} <= there
    assert {f"launch/{p.name}" for p in (source / "launch").glob("*.launch")} <= there
    assert not [name for name in there if name.endswith(".py")]


def test_roslaunch_finds_the_nodes_and_they_run(ros: Ros) -> None:
    launch = ros.launch("control_voz.launch", "robot:=simulator", "sound:=none")
    client = ros.client("/cmd_vel", "/odom")
    eventually(lambda: client.velocities() and client.of("/odom"))
    assert launch.process.poll() is None, launch.text


def test_a_python_without_voz_is_told_in_one_line(ros: Ros, share: Path) -> None:
    node = str(share / "scripts" / "control_voz")
    done = ros.call(node, env={"VOZ_PYTHON": "/usr/bin/python3", "PYTHONPATH": ""})
    assert (done.returncode, done.stdout) == (2, "")
    (line,) = done.stderr.splitlines()
    assert "`make ros1`" in line


def test_a_clone_that_is_gone_is_told_in_one_line_too(
    ros: Ros, share: Path, tmp_path: Path
) -> None:
    moved = tmp_path / "share" / "voz"
    shutil.copytree(share, moved)
    (moved / "clone").write_text("/nowhere\n")
    done = ros.call(str(moved / "scripts" / "recognizer"), env={"PYTHONPATH": ""})
    assert done.returncode == 2
    assert done.stderr == (
        "voz: python3 has no voz; call `make ros1` in the clone of voz, or set VOZ_PYTHON\n"
    )
