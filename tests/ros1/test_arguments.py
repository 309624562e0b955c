"""What the special arguments of a node do to the environment, from which all of voz reads them."""

from __future__ import annotations

import os

import pytest

from voz.errors import ConfigError
from voz.ros1.master import master_uri
from voz.ros1.node import apply_special_arguments

NAMES = ("ROS_NAMESPACE", "ROS_MASTER_URI", "ROS_IP", "ROS_HOSTNAME")


@pytest.fixture(autouse=True)
def _environment(monkeypatch: pytest.MonkeyPatch) -> None:
    """One that says something else; what a test changes is undone."""
    for name in NAMES:
        monkeypatch.setenv(name, "elsewhere")


@pytest.mark.parametrize(
    ("arguments", "changed"),
    [
        ([], {}),
        (["_safety:=false", "cmd_vel:=/base", "word", "__log:=x.log", "__name:=mine"], {}),
        (["__ns:=/r1"], {"ROS_NAMESPACE": "/r1"}),
        (["__ns:="], {"ROS_NAMESPACE": ""}),
        (["__ns:=/r1", "__ns:=/r2"], {"ROS_NAMESPACE": "/r1"}),
        (["__master:=http://robot:11311"], {"ROS_MASTER_URI": "http://robot:11311"}),
        (["__ip:=10.0.0.1"], {"ROS_IP": "10.0.0.1", "ROS_HOSTNAME": None}),
        (["__hostname:=robot"], {"ROS_IP": None, "ROS_HOSTNAME": "robot"}),
        (["__hostname:=robot", "__ip:=10.0.0.1"], {"ROS_IP": None, "ROS_HOSTNAME": "robot"}),
        (["__ip:="], {"ROS_IP": None, "ROS_HOSTNAME": None}),
    ],
)
def test_an_argument_wins_over_the_environment(
    arguments: list[str], changed: dict[str, str | None]
) -> None:
    apply_special_arguments(arguments)
    before = dict.fromkeys(NAMES, "elsewhere")
    assert {name: os.environ.get(name) for name in NAMES} == before | changed


def test_the_master_is_asked_where_the_argument_says() -> None:
    apply_special_arguments(["__master:=http://127.0.0.1:1"])
    assert master_uri() == "http://127.0.0.1:1"


@pytest.mark.parametrize(
    ("argument", "told"),
    [
        ("__ns:=1 bad!", "__ns:= is '1 bad!': set it to a name like /robot1"),
        ("__ns:=~own", "__ns:= is '~own': set it"),
        ("__master:=", "__master:= is '': set it to an address like http://localhost:11311"),
        ("__master:=http://[::1", "__master:= is 'http://[::1': set it"),
        ("__name:=a b", "__name:= is 'a b': set it to a name like control_voz"),
        ("__name:=~own", "__name:= is '~own': set it"),
        ("__ip:=a:=b", "__ip:=a:=b: `:=` stands there twice"),
        ("cmd_vel:=a:=b", "cmd_vel:=a:=b: `:=` stands there twice"),
    ],
)
def test_an_argument_that_cannot_be_is_told_in_one_line(argument: str, told: str) -> None:
    with pytest.raises(ConfigError) as caught:
        apply_special_arguments([argument])
    assert str(caught.value).startswith(told)
    assert {os.environ[name] for name in NAMES} == {"elsewhere"}
