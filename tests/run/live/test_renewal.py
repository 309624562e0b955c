"""A list of commands and a table that are saved are taken while the robot listens."""

from __future__ import annotations

from pathlib import Path

import pytest
from calls import in_process
from live_robot import live_robot, moves, rests, speak, warns
from recordings import FIXTURES

pytestmark = [pytest.mark.slow, pytest.mark.realtime]  # what is spoken has to be in time

CLIP = FIXTURES / "commands" / "festival_slt__go_back.flac"


def build(folder: Path, *commands: str) -> None:
    (folder / "list.txt").write_text("\n".join(commands) + "\n")
    done = in_process("build-lm", str(folder / "list.txt"), "--out", str(folder / "lm"))
    assert done.code == 0, done.err


def test_what_is_saved_is_heard_and_typed_without_a_restart_and_nothing_moves_meanwhile(
    pulse: dict[str, str], tmp_path: Path
) -> None:
    build(tmp_path, "go forward", "stop")
    settings = tmp_path / "voz.toml"
    settings.write_text(f'lm = "{tmp_path / "lm"}"\n')
    with live_robot(pulse, "--listening", "--config", str(settings)) as robot:
        robot.type("go back")
        refused = robot.wait_for(lambda event: event["type"] == "utterance").event
        assert not refused["accepted"]
        robot.type("go forward")
        robot.wait_for(moves)
        since = len(robot.arrived)
        (tmp_path / "list.txt").write_text("go forward\ngo back\nstop\n")
        saved = robot.wait_for(warns("list.txt was saved: the robot stops"), since)
        since = robot.arrived.index(saved)
        robot.wait_for(warns('the commands were renewed: new "go back"'), since)
        robot.wait_for(rests, since)
        assert not any(moves(arrived.event) for arrived in robot.arrived[since:])
        speak(pulse, CLIP)
        heard = robot.wait_for(lambda event: event["type"] == "utterance", since).event
        assert (heard["text"], heard["obeyed"]) == ("go back", True)
        robot.wait_for(moves, since)

        settings.write_text(f'{settings.read_text()}[commands]\n"go back" = {{ drive = -0.2 }}\n')
        robot.wait_for(warns('the commands were renewed: changed "go back"'), since)
        since = len(robot.arrived)
        robot.wait_for(rests, since)
        robot.type("go back")
        assert robot.wait_for(moves, since).event["linear"] == -0.2

        since = len(robot.arrived)
        for broken, why in (
            ('"go back" = { drive = "far" }', '"go back"'),
            ('"go back" = "stop"', "stops the robot, or did: start voz again"),
            ('"go back" = { call = ["nothing:there"] }', "cannot be imported"),
        ):
            settings.write_text(f'lm = "{tmp_path / "lm"}"\n[commands]\n{broken}\n')
            told = robot.wait_for(warns("the new commands are not taken: "), since).event
            assert why in told["text"]
            since = len(robot.arrived)
        (tmp_path / "list.txt").write_text("go forward\ngo [back\n")
        told = robot.wait_for(warns("the new commands are not taken: "), since).event
        assert "list.txt:2" in told["text"]
        assert moves(robot.of("cmd_vel")[-1])  # by the old table, as nothing was taken
        robot.type("stop")
        robot.wait_for(rests, since)


def test_a_new_list_that_could_not_stop_the_robot_is_not_taken(
    pulse: dict[str, str], tmp_path: Path
) -> None:
    build(tmp_path, "go forward", "stop")
    with live_robot(pulse, "--listening", "--lm", str(tmp_path / "lm")) as robot:
        (tmp_path / "lm" / "comandos_voz.sent").write_text("<s> go forward </s>\n")
        (tmp_path / "lm" / "comandos_voz.sha256").touch()
        robot.wait_for(warns("the new commands are not taken: "))
        robot.type("go forward")
        robot.wait_for(lambda event: event["type"] == "cmd_vel" and event["linear"])
        robot.type("stop")
        robot.wait_for(lambda event: event.get("text") == "stop" and event["obeyed"])


def test_a_list_that_was_edited_before_the_start_is_taken_too(tmp_path: Path) -> None:
    build(tmp_path, "go forward", "stop")
    (tmp_path / "list.txt").write_text("go forward\ndance\nstop\n")
    (tmp_path / "said.txt").write_text("dance\n")
    arguments = ("run", "--text", "said.txt", "--no-sound", "--lm", "lm")
    done = in_process(*arguments, cwd=tmp_path)
    assert "list.txt has changed: made lm again" in done.err
    assert 'heard    "dance"' in done.out
    (tmp_path / "list.txt").write_text("go forward\n")
    done = in_process(*arguments, cwd=tmp_path)
    assert "and no command that stops it" in done.err
    assert 'heard    "dance"' in done.out
