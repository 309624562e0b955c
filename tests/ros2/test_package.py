"""The ROS 2 package as colcon builds it: found by ament's index, and its program runs."""

from __future__ import annotations

import json
import os
import re
import runpy
import subprocess
import sys
import xml.etree.ElementTree as ElementTree
from collections.abc import Callable
from pathlib import Path

import pytest
from calls import HANGS
from programs import PATIENCE, Program
from recordings import ROOT

pytestmark = pytest.mark.slow


@pytest.fixture(scope="module")
def prefix(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Where colcon installed the package; it looked through the whole clone for packages."""
    folder = tmp_path_factory.mktemp("colcon")
    places = [f"--{name}-base={folder / name}" for name in ("build", "install")]
    # As a set-up of ROS 2 has it; Debian's colcon has Debian's Python.
    environment = {"PATH": "/usr/bin:/bin", "ROS_VERSION": "2", "HOME": str(folder)}
    done = subprocess.run(
        ["colcon", f"--log-base={folder / 'log'}", "build", *places, "--base-paths", str(ROOT)],
        env=environment,
        cwd=folder,
        capture_output=True,
        text=True,
    )
    assert done.returncode == 0, done.stdout + done.stderr
    assert "ERROR" not in done.stderr
    assert re.findall(r"Finished <<< (\S+)", done.stdout) == ["voz"]
    return folder / "install" / "voz"


def environment(prefix: Path, **more: str) -> dict[str, str]:
    """What `install/setup.bash` sets, and where this voz is."""
    (modules,) = prefix.glob("lib/python3*/site-packages")
    paths = os.pathsep.join([str(modules), str(ROOT)])
    return os.environ | {"AMENT_PREFIX_PATH": str(prefix), "PYTHONPATH": paths, **more}


def test_it_is_laid_out_as_ros2_run_and_ros2_launch_look_for_it(prefix: Path) -> None:
    for place in (
        "lib/voz/voz",
        "share/voz/package.xml",
        "share/voz/launch/voz.launch.py",
        "share/ament_index/resource_index/packages/voz",
    ):
        assert (prefix / place).is_file(), place
    assert os.access(prefix / "lib/voz/voz", os.X_OK)


def test_aments_own_index_finds_it(prefix: Path) -> None:
    code = "from ament_index_python.packages import *; print(get_package_share_directory('voz'))"
    done = subprocess.run(
        ["/usr/bin/python3", "-c", code], env=environment(prefix), capture_output=True, text=True
    )
    assert done.stdout.strip() == str(prefix / "share" / "voz"), done.stderr


@pytest.mark.realtime
def test_its_program_drives_a_base(
    prefix: Path,
    domain: int,
    own: Callable[..., Program],
    monkeypatch: pytest.MonkeyPatch,
    tmp_path: Path,
) -> None:
    base = own("base.py", patience=1)
    base.wait_for(lambda line: line.get("ready"))
    for name, value in environment(prefix, VOZ_PYTHON=sys.executable).items():
        monkeypatch.setenv(name, value)
    voz = Program(
        [str(prefix / "lib/voz/voz"), "--text", "-", "--listening", "--events", "-", "--no-sound"]
    )
    voz.say("go forward")
    base.wait_for(lambda line: line.get("linear") == 0.1)
    voz.process.terminate()
    base.wait_for(lambda line: line.get("linear") == 0)
    assert voz.process.wait(PATIENCE) == 128 + 15
    voz.close()


def called(prefix: Path, *arguments: str, **more: str) -> subprocess.CompletedProcess[str]:
    program = str(prefix / "lib" / "voz" / "voz")
    return subprocess.run(
        [program, *arguments],
        env=environment(prefix, **({"VOZ_PYTHON": sys.executable} | more)),
        capture_output=True,
        text=True,
        timeout=HANGS,
    )


def test_a_subcommand_is_the_one_of_voz(prefix: Path) -> None:
    done = called(prefix, "say", "--list-voices")
    assert (done.returncode, "kal_diphone" in done.stdout) == (0, True), done.stderr


def test_ros_arguments_are_refused_in_one_line(prefix: Path) -> None:
    done = called(prefix, "--ros-args", "-r", "__ns:=/robot1")
    assert (done.returncode, done.stdout) == (2, "")
    assert "[ros2] of voz.toml" in done.stderr
    assert done.stderr.count("\n") == 1


def test_a_python_without_voz_is_told_in_one_line(prefix: Path) -> None:
    (modules,) = prefix.glob("lib/python3*/site-packages")
    done = called(prefix, VOZ_PYTHON="/usr/bin/python3", PYTHONPATH=str(modules))
    assert (done.returncode, done.stdout) == (2, "")
    assert "`make ros2`" in done.stderr
    assert done.stderr.count("\n") == 1


def test_the_launch_file_starts_the_program_that_it_is_installed_with(prefix: Path) -> None:
    installed = runpy.run_path(str(prefix / "share/voz/launch/voz.launch.py"))
    assert installed["program"]() == str(prefix / "lib/voz/voz")
    in_the_clone = runpy.run_path(str(ROOT / "ros/launch/voz.launch.py"))
    assert in_the_clone["program"]() == "voz"


def test_both_descriptions_name_the_same_version() -> None:
    package = ElementTree.parse(ROOT / "ros" / "package.xml").getroot()
    setup = (ROOT / "ros" / "setup.py").read_text()
    assert f"version={json.dumps(package.findtext('version'))}" in setup
