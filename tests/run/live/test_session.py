"""`voz run` with a microphone: commands spoken into it, and how it ends."""

from __future__ import annotations

import signal
import subprocess
import time
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import msgspec
import pytest
from calls import VOZ, in_process
from live_robot import AT_REST, LiveRobot, live_robot, moves, rests, speak, velocity
from recordings import FIXTURES

import voz
from voz.events import Event, Notice, Partial, Utterance

pytestmark = pytest.mark.slow


def clip(text: str, voice: str = "festival_slt") -> Path:
    return FIXTURES / "commands" / f"{voice}__{text.replace(' ', '_')}.flac"


def say(robot: LiveRobot, environment: dict[str, str], text: str) -> None:
    """Say a command until it is settled in time."""
    speak_in_time(robot, environment, clip(text))


def speak_in_time(
    robot: LiveRobot, environment: dict[str, str], path: Path, commands: int = 1
) -> list[dict[str, Any]]:
    """Speak a recording of so many commands, and again if one was settled too late.

    It is where the machine was too slow to follow: the robot stops, and waits for a new command.
    Returns the utterances of the last time.
    """
    since = len(robot.arrived)
    speak(environment, path)
    robot.wait_for(lambda _: len(robot.of("utterance", since)) >= commands, since)
    heard = robot.of("utterance", since)
    if not any(map(is_late, heard)):
        return heard
    assert stops(robot)
    return speak_in_time(robot, environment, path, commands)


def is_late(heard: dict[str, Any]) -> bool:
    return heard.get("ignored") == "too_late"


def heard_in_time(robot: LiveRobot) -> list[dict[str, Any]]:
    return [heard for heard in robot.of("utterance") if not is_late(heard)]


def stops(robot: LiveRobot) -> list[str]:
    """Why the robot was stopped without a command."""
    return [event["text"] for event in robot.of("warning") if event.get("stops")]


def velocities(robot: LiveRobot) -> list[tuple[float, float]]:
    """Those that it was driven with, each once."""
    return list(dict.fromkeys(velocity(event) for event in robot.of("cmd_vel")))


def by_the_rules(robot: LiveRobot, listening: bool) -> list[tuple[float, float]]:
    """Those that follow from what was obeyed and what stopped it, each once."""
    controller = voz.Controller([], listening=listening)
    found = [controller.velocities]
    for arrived in robot.arrived:
        event = msgspec.convert(arrived.event, Event)
        if isinstance(event, Partial) or (isinstance(event, Utterance) and event.obeyed):
            controller.hear(event)
        elif isinstance(event, Notice) and event.stops:
            controller.halt()
        found.append(controller.velocities)
    return list(dict.fromkeys(found))


def check_velocities(
    robot: LiveRobot, seen: list[tuple[float, float]], listening: bool = True
) -> None:
    """Check that it drove as expected; where the machine was too slow it was stopped besides."""
    assert set(velocities(robot)) <= set(by_the_rules(robot, listening))
    assert stops(robot) or velocities(robot) == [AT_REST, *seen]
    assert rests(robot.arrived[-1].event)


@pytest.fixture
def robot(pulse: dict[str, str]) -> Iterator[LiveRobot]:
    with live_robot(pulse, "--listening") as robot:
        yield robot


# Several short sessions: a long one with nothing in its way is rare on a busy machine.


@pytest.mark.realtime
@pytest.mark.parametrize(
    ("texts", "seen", "selected"),
    [
        (["go forward", "turn left", "stop"], [(0.1, 0), (0.1, 0.1)], []),
        (["go forward", "speed up", "slow down"], [(0.1, 0), (0.15, 0)], []),
        (["rotate right", "go back", "stop"], [(0, -0.1), (-0.1, 0)], []),
        (["point beer", "fold arm"], [], [1, 100]),
    ],
)
def test_commands_that_are_spoken_are_obeyed(
    texts: list[str],
    seen: list[tuple[float, float]],
    selected: list[int],
    robot: LiveRobot,
    pulse: dict[str, str],
) -> None:
    for text in texts:
        say(robot, pulse, text)
    assert robot.end() == 143
    heard = heard_in_time(robot)
    assert [event["text"] for event in heard] == robot.commands() == texts
    assert [event["value"] for event in robot.of("selected_object")] == selected
    check_velocities(robot, seen)
    assert all(event["latency"] > 0 for event in heard)


@pytest.mark.realtime
def test_commands_are_obeyed_from_start_speech_to_stop_speech(pulse: dict[str, str]) -> None:
    with live_robot(pulse) as robot:
        for text in ("go forward", "start speech", "go back", "stop speech"):
            say(robot, pulse, text)
        assert robot.end() == 143
    first, *others = heard_in_time(robot)
    assert (first["text"], first["obeyed"]) == ("go forward", False)
    assert first["ignored"] == "not_listening"
    assert [event["text"] for event in others] == ["start speech", "go back", "stop speech"]
    assert all(event["obeyed"] for event in others)
    assert [event["text"] for event in robot.of("reply")] == [
        "bep bep. I am listening you",
        "bep bep. I stop listening",
    ]
    check_velocities(robot, [(-0.1, 0)], listening=False)
    assert all(event["latency"] > 0 for event in robot.of("utterance"))


@pytest.mark.parametrize(
    ("number", "code"),
    [(signal.SIGTERM, 143), (signal.SIGINT, 130), (signal.SIGHUP, 129), (signal.SIGQUIT, 131)],
)
def test_s7_a_signal_ends_with_zero_velocity_as_the_last_event(
    number: signal.Signals, code: int, robot: LiveRobot
) -> None:
    robot.type("go forward")
    robot.wait_for(moves)
    assert robot.end(number) == code
    assert rests(robot.arrived[-1].event)
    assert moves(robot.arrived[-2].event)
    assert "Traceback" not in robot.words


@pytest.mark.parametrize(
    ("options", "input_", "told"),
    [
        (
            [],
            subprocess.PIPE,
            'the microphone default and typed commands; say "start speech" first',
        ),
        (
            ["--listening", "-d", "mic.mon"],
            subprocess.PIPE,
            "the microphone mic.monitor and typed commands",
        ),
        ([], subprocess.DEVNULL, 'the microphone default; say "start speech" first'),
    ],
)
def test_without_a_terminal_it_says_when_it_hears_and_whom(
    options: list[str], input_: int, told: str, pulse: dict[str, str], tmp_path: Path
) -> None:
    events = tmp_path / "events.jsonl"
    with subprocess.Popen(
        [*VOZ, "run", "--no-sound", *options, "--events", str(events)],
        env=pulse,
        stdin=input_,
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
    ) as process:
        while not (events.exists() and events.read_text()):
            assert process.poll() is None
            time.sleep(0.05)
        process.terminate()
        _, said = process.communicate(timeout=60)
    assert said == f"listening to {told}\n"


def test_the_time_is_that_since_the_start(robot: LiveRobot) -> None:
    robot.type("go forward")
    moved = robot.wait_for(moves)
    assert 0 < moved.event["t"] < moved.when - robot.begun
    times = [event["t"] for event in robot.of("cmd_vel")]
    assert times == sorted(times)


def test_no_microphone_at_all_is_one_line_that_names_the_ways_without_one(
    no_sound: dict[str, str],
) -> None:
    result = in_process("run", "--no-sound", env=no_sound)
    assert result.complaint == (
        "voz: there is no microphone; connect one, or use `--web` to speak into a browser, "
        "`--text -` to type commands, or `--wav FILE` for recordings"
    )
