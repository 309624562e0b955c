from __future__ import annotations

from contextlib import suppress
from pathlib import Path
from xml.etree import ElementTree

import pytest
from hypothesis import given
from hypothesis import strategies as st

from voz.errors import ConfigError
from voz.ros2.discovery import cyclone_settings, domain_number
from voz.settings import Ros2


def settings(**environment: str) -> ElementTree.Element:
    own, end, rest = cyclone_settings(environment).partition("</CycloneDDS>,")
    assert rest == environment.get("CYCLONEDDS_URI", "")
    return ElementTree.fromstring(own + end.rstrip(","))


def peers(tree: ElementTree.Element) -> list[str | None]:
    return [peer.get("address") for peer in tree.iter("Peer")]


def test_the_domain_is_that_of_the_settings_or_the_environment_or_0() -> None:
    assert domain_number(Ros2(domain=7), {"ROS_DOMAIN_ID": "8"}) == 7
    assert domain_number(Ros2(), {"ROS_DOMAIN_ID": "8"}) == 8
    assert domain_number(Ros2(), {"ROS_DOMAIN_ID": ""}) == 0
    assert domain_number(Ros2(), {}) == 0


@pytest.mark.parametrize("said", ["-1", "233", "one", "1.5", "²", "9" * 5000])
def test_a_domain_that_cannot_be_is_refused(said: str) -> None:
    with pytest.raises(ConfigError, match=r"^ROS_DOMAIN_ID is .{,60} 0 to 232"):
        domain_number(Ros2(), {"ROS_DOMAIN_ID": said})


@given(st.text(max_size=8) | st.integers().map(str))
def test_no_domain_from_outside_the_range_comes_from_the_environment(said: str) -> None:
    with suppress(ConfigError):
        assert domain_number(Ros2(), {"ROS_DOMAIN_ID": said}) in range(233)


@pytest.mark.parametrize(
    "environment",
    [
        {"ROS_AUTOMATIC_DISCOVERY_RANGE": "LOCALHOST"},
        {"ROS_LOCALHOST_ONLY": "1"},
        {"ROS_LOCALHOST_ONLY": "1", "ROS_AUTOMATIC_DISCOVERY_RANGE": "SUBNET"},
    ],
)
def test_localhost_uses_the_loopback_interface_alone(environment: dict[str, str]) -> None:
    tree = settings(**environment)
    assert [place.get("address") for place in tree.iter("NetworkInterface")] == ["127.0.0.1"]
    assert tree.findtext(".//AllowMulticast") == "false"
    assert peers(tree) == ["127.0.0.1"]


@pytest.mark.parametrize("environment", [{}, {"ROS_LOCALHOST_ONLY": "0"}])
def test_the_subnet_is_the_default(environment: dict[str, str]) -> None:
    tree = settings(**environment)
    assert not list(tree.iter("NetworkInterface"))
    assert tree.find(".//AllowMulticast") is None
    assert peers(tree) == ["127.0.0.1"]


def test_static_peers_are_asked_too_however_they_are_written() -> None:
    assert peers(settings(ROS_STATIC_PEERS='10.0.0.7;;a"b<c')) == ["127.0.0.1", "10.0.0.7", 'a"b<c']


def test_off_is_found_by_nobody() -> None:
    tree = settings(ROS_AUTOMATIC_DISCOVERY_RANGE="OFF", ROS_STATIC_PEERS="10.0.0.7")
    assert peers(tree) == []
    assert tree.findtext(".//AllowMulticast") == "false"
    assert (tree.findtext(".//Tag") or "").startswith("ros_discovery_off_")


def test_the_system_default_leaves_discovery_to_cyclone() -> None:
    tree = settings(ROS_AUTOMATIC_DISCOVERY_RANGE="SYSTEM_DEFAULT", ROS_STATIC_PEERS="10.0.0.7")
    assert tree.find(".//Discovery") is None


def test_what_the_user_says_to_cyclone_comes_last_and_so_wins() -> None:
    settings(CYCLONEDDS_URI="file:///etc/cyclone.xml")


LO = '<CycloneDDS><Domain><General><Interfaces><NetworkInterface name="lo"/></Interfaces></General>'
LO += "</Domain></CycloneDDS>"


@pytest.mark.parametrize("written", ["{xml}", "file://{file}", "{file}", "<!-- mine, -->,{file}"])
def test_interfaces_that_the_user_names_are_the_only_ones(written: str, tmp_path: Path) -> None:
    (tmp_path / "cyclone.xml").write_text(LO)
    uri = written.format(xml=LO, file=tmp_path / "cyclone.xml")
    tree = settings(ROS_AUTOMATIC_DISCOVERY_RANGE="LOCALHOST", CYCLONEDDS_URI=uri)
    assert not list(tree.iter("NetworkInterface"))
    assert tree.findtext(".//AllowMulticast") == "false"


@pytest.mark.parametrize("uri", [f"<!-- {LO} -->", "file:///none.xml", "/dev/zero", "a\0b", ""])
def test_what_names_no_interface_leaves_the_loopback(uri: str) -> None:
    tree = settings(ROS_AUTOMATIC_DISCOVERY_RANGE="LOCALHOST", CYCLONEDDS_URI=uri)
    assert [place.get("address") for place in tree.iter("NetworkInterface")] == ["127.0.0.1"]


def test_a_range_that_cannot_be_is_refused() -> None:
    with pytest.raises(ConfigError, match="ROS_AUTOMATIC_DISCOVERY_RANGE is 'NEAR': set it to"):
        cyclone_settings({"ROS_AUTOMATIC_DISCOVERY_RANGE": "NEAR"})
