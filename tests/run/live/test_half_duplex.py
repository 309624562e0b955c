"""A robot whose microphone hears its own loudspeaker, both of a real sound server."""

from __future__ import annotations

import subprocess
import time
from pathlib import Path

import pytest
from driving import STARTED
from live_robot import LiveRobot, live_robot, moves, rests, speak
from loudspeaker import Recorder, is_silent, recording
from programs import PATIENCE
from recordings import FIXTURES

# To clean the sound of an echo takes half of a slow core: beside others it comes too late.
pytestmark = [pytest.mark.slow, pytest.mark.realtime, pytest.mark.alone]

# A room delays by the same time always. With less latency a busy machine's loopback runs out of
# sound; then, as without adjust_time=0, it changes its rate, and no echo canceller can follow.
LOOPBACK = (
    "load-module module-loopback source=speaker.monitor sink=mic latency_msec=200 adjust_time=0"
)

STORY = (
    "this is a long story of a small machine. it has two wheels, a camera and a good friend. every "
    "morning it takes a cup of tea to the window, and every evening it finds its way home again"
)

BARGE_IN = f"""
[speech]
barge_in = true

[commands]
"fold arm" = {{ say = "{STORY}" }}
"""


@pytest.fixture
def one_room(
    own_pulse: tuple[dict[str, str], subprocess.Popen[bytes]],
) -> dict[str, str]:
    """What goes to the loudspeaker comes into the microphone too."""
    environment, _ = own_pulse
    subprocess.run(["pactl", *LOOPBACK.split()], env=environment, check=True, capture_output=True)
    return environment


def say(robot: LiveRobot, environment: dict[str, str], text: str) -> None:
    """Say a command until it is obeyed: a busy machine loses sound, and stops the robot for it."""
    since = len(robot.arrived)
    name = f"festival_slt__{text.replace(' ', '_')}.flac"
    for _ in range(4):
        speak(environment, FIXTURES / "commands" / name)
        deadline = time.monotonic() + 1.5
        while time.monotonic() < deadline:
            if text in [event["text"] for event in robot.of("utterance", since) if event["obeyed"]]:
                return
            time.sleep(0.02)
    raise AssertionError((text, robot.of("utterance", since), robot.words))


def test_with_a_headset_the_reply_is_there_to_be_heard(one_room: dict[str, str]) -> None:
    with live_robot(one_room, "--no-half-duplex", sound=True) as robot:
        say(robot, one_room, "start speech")
        robot.wait_for(lambda e: e["type"] == "utterance" and e["text"] != "start speech")
        assert [event["text"] for event in robot.of("reply")] == [STARTED]


def test_a_reply_commands_nothing_a_command_ends_it_and_stop_halts_the_robot_in_its_midst(
    one_room: dict[str, str], tmp_path: Path
) -> None:
    (tmp_path / "voz.toml").write_text(BARGE_IN)
    with (
        live_robot(one_room, "--config", str(tmp_path / "voz.toml"), sound=True) as robot,
        recording(one_room) as loudspeaker,
    ):
        say(robot, one_room, "start speech")
        sounds(robot, loudspeaker)
        falls_silent(loudspeaker)
        assert {event["text"] for event in robot.of("utterance")} == {"start speech"}
        since = begin_story(robot, one_room, loudspeaker)
        say(robot, one_room, "go forward")
        robot.wait_for(moves, since)
        falls_silent(loudspeaker)
        since = begin_story(robot, one_room, loudspeaker)
        say(robot, one_room, "stop")
        robot.wait_for(rests, since)
        falls_silent(loudspeaker)
        assert [event["text"] for event in robot.of("reply")] == [STARTED, STORY, STORY]
        assert set(robot.commands()) == {"start speech", "fold arm", "go forward", "stop"}


def begin_story(robot: LiveRobot, environment: dict[str, str], loudspeaker: Recorder) -> int:
    """Let the robot begin to tell its story; gives the number of events so far."""
    say(robot, environment, "fold arm")
    sounds(robot, loudspeaker)
    return len(robot.arrived)


def sounds(robot: LiveRobot, loudspeaker: Recorder) -> None:
    """Wait until the loudspeaker sounds."""
    deadline = time.monotonic() + PATIENCE
    while is_silent(loudspeaker.pass_by(0.2)):
        assert robot.process.poll() is None, robot.words
        assert time.monotonic() < deadline, robot.words


def falls_silent(loudspeaker: Recorder) -> None:
    """Wait until the loudspeaker is silent; the story would go on for longer."""
    deadline = time.monotonic() + 4
    while not is_silent(loudspeaker.pass_by(0.5)):
        assert time.monotonic() < deadline
