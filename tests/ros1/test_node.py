"""How every node begins and ends."""

from __future__ import annotations

import math
import socket
import sys
from pathlib import Path
from types import SimpleNamespace

import pytest
from hypothesis import given
from hypothesis import strategies as st
from recordings import ROOT
from ros1.ros import Ros

from voz.errors import ConfigError
from voz.ros1.master import check_namespace
from voz.ros1.node import read_settings

NODES = ["recognizer", "control_voz", "voz", "simulator", "soundplay"]


@pytest.mark.slow
def test_a_node_reads_no_settings_of_the_folder_that_it_starts_in(ros: Ros, tmp_path: Path) -> None:
    (tmp_path / "voz.toml").write_text("nonsense")
    done = ros.call(str(ROOT / "ros" / "scripts" / "voz"), "_safety:=perhaps", cwd=tmp_path)
    (line,) = done.stderr.splitlines()
    assert "~safety: perhaps" in line


@pytest.mark.parametrize("name", NODES)
def test_without_a_master_a_node_ends_at_once_with_one_line(name: str, ros: Ros) -> None:
    done = ros.call(str(ROOT / "ros" / "scripts" / name), "__master:=http://127.0.0.1:1")
    assert done.returncode == 2
    (line,) = done.stderr.splitlines()
    assert "there is no ROS master at http://127.0.0.1:1 (Connection refused)" in line


@pytest.mark.slow
def test_something_else_at_the_masters_address_is_no_master(ros: Ros) -> None:
    with socket.create_server(("127.0.0.1", 0)) as silent:
        uri = f"http://127.0.0.1:{silent.getsockname()[1]}"
        done = ros.call(str(ROOT / "ros" / "scripts" / "voz"), env={"ROS_MASTER_URI": uri})
    assert done.returncode == 2
    (line,) = done.stderr.splitlines()
    assert "timed out" in line


@pytest.mark.parametrize(
    ("variable", "said", "told"),
    [
        ("ROS_MASTER_URI", "http://[::1", "invalid ROS_MASTER_URI"),
        ("ROS_MASTER_URI", "http://localhost:99999", "invalid ROS_MASTER_URI"),
        ("ROS_MASTER_URI", "http://localhost:" + "9" * 5000, "invalid ROS_MASTER_URI"),
        ("ROS_NAMESPACE", "1 bad!", "ROS_NAMESPACE is '1 bad!'"),
        ("ROS_NAMESPACE", "\x1b[2J", r"ROS_NAMESPACE is '\x1b[2J'"),
    ],
)
def test_an_environment_that_cannot_be_is_one_line(
    ros: Ros, variable: str, said: str, told: str
) -> None:
    done = ros.call(str(ROOT / "ros" / "scripts" / "voz"), env={variable: said})
    assert done.returncode == 2
    (line,) = done.stderr.splitlines()
    assert told in line


@pytest.mark.parametrize("namespace", ["", "/", "robot1", "/robot1/", "/a/b_2"])
def test_a_namespace_that_can_be_is_one(namespace: str, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("ROS_NAMESPACE", namespace)
    check_namespace()


@pytest.mark.slow
@pytest.mark.parametrize(
    ("name", "parameter", "what"),
    [
        ("control_voz", "_safety:=perhaps", "~safety: perhaps is neither true nor false"),
        ("control_voz", "_sound:=loud", "~sound: loud is none of voz, ros, none"),
        ("control_voz", "_config:=/none.toml", "/none.toml: cannot be read"),
        ("recognizer", "_threshold:=high", "~threshold: high is not a number"),
        ("recognizer", "_dict:=/1234.dic", "~lm and ~dict are both needed"),
        ("recognizer", "_search:=best", "a parameter of the node cannot be used"),
    ],
)
def test_a_parameter_that_cannot_be_is_one_line(
    ros: Ros, name: str, parameter: str, what: str
) -> None:
    done = ros.call(str(ROOT / "ros" / "scripts" / name), parameter)
    assert done.returncode == 2
    (line,) = done.stderr.splitlines()
    assert what in line


HANGS = """
import atexit, os, signal, threading, time
from voz.ros1.node import run_node

def work(node):
    threading.Thread(target=time.sleep, args=(600,), name="voz-hearing", daemon=True).start()
    os.kill(os.getpid(), signal.SIGTERM)  # not driving yet: it raises
    time.sleep(600)

atexit.register(time.sleep, 600)  # as PortAudio waits for a stream that is open
run_node("hanging", work)
"""


@pytest.mark.slow
def test_a_signal_while_it_starts_ends_it_though_the_sound_system_hangs(ros: Ros) -> None:
    done = ros.call(str(ROOT / "ros" / "python"), "-c", HANGS)
    assert (done.returncode, done.stderr) == (0, "")


VALUES = st.one_of(
    st.floats(),
    st.floats(0, 1),
    st.integers(),
    st.booleans(),
    st.text(max_size=4),
    st.sampled_from(["nan", "inf", "-1", "0.5", "1e999"]),
)


@given(VALUES)
def test_no_value_from_outside_its_range_comes_from_a_parameter(value: object) -> None:
    with pytest.MonkeyPatch.context() as patch:
        held = {"~threshold": value}
        patch.setitem(sys.modules, "rospy", SimpleNamespace(get_param=held.get))
        try:
            threshold = read_settings().recognition.threshold
        except ConfigError:
            return
    assert threshold is None if str(value).strip() == "" else 0 <= float(str(value)) <= 1
    assert threshold is None or threshold == pytest.approx(float(str(value)), abs=math.ulp(1))
