"""A list of commands that is made anew is taken while the robot listens."""

from __future__ import annotations

from pathlib import Path

import pytest
from calls import in_process
from live_robot import live_robot, speak, warns
from recordings import FIXTURES

pytestmark = pytest.mark.slow

CLIP = FIXTURES / "commands" / "festival_slt__go_back.flac"


def build(folder: Path, *commands: str) -> None:
    (folder / "list.txt").write_text("\n".join(commands) + "\n")
    done = in_process("build-lm", str(folder / "list.txt"), "--out", str(folder))
    assert done.code == 0, done.err


def test_what_is_added_is_heard_and_typed_without_a_restart(
    pulse: dict[str, str], tmp_path: Path
) -> None:
    build(tmp_path, "go forward", "stop")
    with live_robot(pulse, "--listening", "--lm", str(tmp_path)) as robot:
        robot.type("go back")
        refused = robot.wait_for(lambda event: event["type"] == "utterance").event
        assert not refused["accepted"]
        build(tmp_path, "go forward", "go back", "stop")
        robot.wait_for(warns("there are new commands: 3 sentences"))
        since = len(robot.arrived)
        robot.type("go back")
        robot.wait_for(lambda event: event.get("obeyed") is True, since)
        robot.type("stop")
        robot.wait_for(lambda event: event.get("text") == "stop", since)
        since = len(robot.arrived)
        speak(pulse, CLIP)
        heard = robot.wait_for(lambda event: event["type"] == "utterance", since).event
        assert (heard["text"], heard["obeyed"]) == ("go back", True)


def test_a_new_list_that_could_not_stop_the_robot_is_not_taken(
    pulse: dict[str, str], tmp_path: Path
) -> None:
    build(tmp_path, "go forward", "stop")
    with live_robot(pulse, "--listening", "--lm", str(tmp_path)) as robot:
        (tmp_path / "comandos_voz.sent").write_text("<s> go forward </s>\n")
        (tmp_path / "comandos_voz.sha256").touch()
        robot.wait_for(warns("the new commands are not taken: "))
        robot.type("go forward")
        robot.wait_for(lambda event: event["type"] == "cmd_vel" and event["linear"])
        robot.type("stop")
        robot.wait_for(lambda event: event.get("text") == "stop" and event["obeyed"])
