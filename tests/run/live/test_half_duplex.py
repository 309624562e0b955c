"""A robot whose microphone hears its own loudspeaker, both of a real sound server."""

from __future__ import annotations

import subprocess
import time
from collections.abc import Iterator

import pytest
from driving import STARTED
from live_robot import LiveRobot, live_robot, speak
from recordings import FIXTURES

pytestmark = [pytest.mark.slow, pytest.mark.realtime]

LOOPBACK = "load-module module-loopback source=speaker.monitor sink=mic latency_msec=30"


@pytest.fixture
def one_room(
    own_pulse: tuple[dict[str, str], subprocess.Popen[bytes]],
) -> dict[str, str]:
    """What goes to the loudspeaker comes into the microphone too."""
    environment, _ = own_pulse
    subprocess.run(["pactl", *LOOPBACK.split()], env=environment, check=True, capture_output=True)
    return environment


@pytest.fixture(params=[(), ("--no-half-duplex",)], ids=["half", "full"])
def robot(one_room: dict[str, str], request: pytest.FixtureRequest) -> Iterator[LiveRobot]:
    with live_robot(one_room, *request.param, sound=True) as robot:
        yield robot


def say(robot: LiveRobot, environment: dict[str, str], text: str) -> None:
    since = len(robot.arrived)
    name = f"festival_slt__{text.replace(' ', '_')}.flac"
    speak(environment, FIXTURES / "commands" / name)
    robot.wait_for(lambda e: e["type"] == "utterance" and e["text"] == text, since)


def test_the_robot_does_not_take_its_reply_for_speech(
    robot: LiveRobot, one_room: dict[str, str], request: pytest.FixtureRequest
) -> None:
    say(robot, one_room, "start speech")
    time.sleep(5)  # the reply takes 3 s, at the very first time festival 2 s before it
    heard = [event["text"] for event in robot.of("utterance")]
    if "half" in request.node.name:
        assert heard == ["start speech"]
    else:
        assert len(heard) > 1  # the reply was there to be heard
    say(robot, one_room, "go forward")
    assert robot.commands()[-1] == "go forward"
    assert [event["text"] for event in robot.of("reply")] == [STARTED]
