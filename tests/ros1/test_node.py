"""How every node begins and ends."""

from __future__ import annotations

import socket

import pytest
from recordings import ROOT
from ros1.ros import Ros

NODES = ["recognizer", "control_voz", "voz", "simulator"]


@pytest.mark.parametrize("name", NODES)
def test_without_a_master_a_node_ends_at_once_with_one_line(name: str, ros: Ros) -> None:
    ros.master.kill()
    done = ros.call(str(ROOT / "ros" / "scripts" / name))
    assert done.returncode == 2
    (line,) = done.stderr.splitlines()
    assert "there is no ROS master at http://127.0.0.1" in line


def test_something_else_at_the_masters_address_is_no_master(ros: Ros) -> None:
    with socket.create_server(("127.0.0.1", 0)) as silent:
        uri = f"http://127.0.0.1:{silent.getsockname()[1]}"
        done = ros.call(str(ROOT / "ros" / "scripts" / "voz"), env={"ROS_MASTER_URI": uri})
    assert done.returncode == 2
    (line,) = done.stderr.splitlines()
    assert "timed out" in line


@pytest.mark.parametrize(
    ("parameter", "what"),
    [
        ("_safety:=perhaps", "~safety: perhaps is neither true nor false"),
        ("_sound:=loud", "~sound: loud is none of voz, ros, none"),
        ("_config:=/none.toml", "/none.toml: cannot be read"),
    ],
)
def test_a_parameter_that_cannot_be_is_one_line(ros: Ros, parameter: str, what: str) -> None:
    done = ros.call(str(ROOT / "ros" / "scripts" / "control_voz"), parameter)
    assert done.returncode == 2
    (line,) = done.stderr.splitlines()
    assert what in line
