"""`voz run --listen-ros`: two recognizers for one robot, a microphone's and another program's."""

from __future__ import annotations

import os
from collections.abc import Callable
from typing import Any

import pytest
from live_robot import live_robot, moves, rests, speak, warns
from programs import Program, wait_until
from recordings import FIXTURES

from voz.ros2 import listen_to_recognizer
from voz.settings import Ros2

pytestmark = pytest.mark.slow

BREAKS = """
from voz.run.sources import TextCommands
take = TextCommands.take
def breaks(self, text, *source):
    if text == "break":
        raise MemoryError
    take(self, text, *source)
TextCommands.take = breaks
"""


@pytest.mark.realtime
def test_both_are_obeyed_and_what_the_other_heard_is_not_published_again(
    pulse: dict[str, str], domain: int, own: Callable[..., Program]
) -> None:
    environment = pulse | of_ros()
    other, published = own("cyclone_peer.py"), list[str]()

    def until(true: Callable[[], object], say: Callable[[str], None], text: str) -> None:
        """Say it until it is true: programs need some time to find each other."""

        def said() -> object:
            say(text)
            return true()

        wait_until(said)

    def aloud(name: str) -> None:
        before = len(robot.arrived)
        speak(environment, FIXTURES / "commands" / name)
        robot.wait_for(lambda event: event["type"] == "utterance", before)

    with (
        listen_to_recognizer(Ros2(), published.append, published.append),
        live_robot(environment, "--robot", "ros2", "--listen-ros", "--listening") as robot,
    ):
        until(lambda: "hello" in published, other.say, "hello")
        until(lambda: any(moves(arrived.event) for arrived in robot.arrived), other.say, "go back")
        until(lambda: "start speech" in published, robot.type, "start speech")

        since = len(robot.arrived)
        other.say("Turn  LEFT")
        obeyed = robot.wait_for(is_obeyed("turn left"), since).event
        assert (obeyed["source"], obeyed["confidence"]) == ("ros2", 1.0)
        # A recording that stutters on a busy machine is rightly refused: it is said again.
        until(lambda: "point beer" in robot.commands(), aloud, "festival_slt__point_beer.flac")
        assert robot.wait_for(is_obeyed("point beer"), since).event["source"] == "microphone"
        # It publishes in lower case, single spaces between, in the order of what it obeys.
        wait_until(lambda: "point beer" in published)
        assert [event["value"] for event in robot.of("selected_object", since)] == [1]
    assert "turn left" not in published


def is_obeyed(text: str) -> Callable[[dict[str, Any]], bool]:
    return lambda event: event["type"] == "utterance" and event["obeyed"] and event["text"] == text


def test_the_robot_stops_once_the_other_is_heard_no_more(
    pulse: dict[str, str], domain: int, own: Callable[..., Program]
) -> None:
    other = own("cyclone_peer.py")
    options = ["--robot", "simulator", "--listen-ros", "--listening"]
    with live_robot(pulse | of_ros(), *options, before=BREAKS) as robot:
        robot.type("go forward")
        since = robot.arrived.index(robot.wait_for(moves))

        def is_told() -> bool:
            other.say("break")
            return any("is no longer received (MemoryError())" in w for w in robot.warnings(since))

        wait_until(is_told)
        robot.wait_for(warns("is no longer received (MemoryError()): the robot stops"), since)
        robot.wait_for(rests, since)


def of_ros() -> dict[str, str]:
    return {name: value for name, value in os.environ.items() if name.startswith("ROS_")}
