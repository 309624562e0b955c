"""A live robot with a name that asks back: only what is said to it moves it."""

from __future__ import annotations

import time
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest
from live_robot import LiveRobot, live_robot, moves, rests, speak
from recordings import FIXTURES

from voz.speech.synthesis import cached_speech

pytestmark = [pytest.mark.slow, pytest.mark.realtime]

SETTINGS = '[recognition]\nname = "hey robot"\nask = "always"\n'


EASILY_ASKED = "import voz.recognition.thresholds as t; t.ASK_BACK_ODDS_FACTOR = 1000; "
"""How sure it is of a sound in the air varies more than what is nearly sure."""

PAUSE = 1.0
"""After a sentence, s: what follows at once is no name."""


def by_festival(text: str) -> Path:
    return cached_speech(text, "kal_diphone")


def clip(text: str) -> Path:
    return FIXTURES / "commands" / f"festival_slt__{text.replace(' ', '_')}.flac"


def heard(robot: LiveRobot, pulse: dict[str, str], recording: Path) -> dict[str, object]:
    """Speak a recording, again if the machine was too slow to follow; gives what was heard."""
    since = len(robot.arrived)
    speak(pulse, recording)
    event = robot.wait_for(lambda event: event["type"] == "utterance", since).event
    return heard(robot, pulse, recording) if event.get("ignored") == "too_late" else event


def is_attention(awake: bool) -> Callable[[dict[str, Any]], bool]:
    return lambda event: event["type"] == "attention" and event["awake"] == awake


def test_nothing_moves_before_the_name_and_an_answer_by_voice_does_what_was_asked(
    pulse: dict[str, str], tmp_path: Path
) -> None:
    settings = tmp_path / "voz.toml"
    settings.write_text(SETTINGS)
    with live_robot(pulse, "--config", str(settings), "--listening", before=EASILY_ASKED) as robot:
        assert heard(robot, pulse, clip("go forward"))["ignored"] == "asleep"
        assert heard(robot, pulse, by_festival("hey robot"))["named"]
        robot.wait_for(is_attention(awake=True))
        assert not any(map(moves, robot.of("cmd_vel")))
        assert heard(robot, pulse, clip("go forward"))["obeyed"]
        robot.wait_for(moves)

        robot.wait_for(is_attention(awake=False), len(robot.arrived))
        since = len(robot.arrived)
        assert heard(robot, pulse, clip("stop"))["obeyed"]
        robot.wait_for(rests, since)

        time.sleep(PAUSE)
        heard(robot, pulse, by_festival("hey robot"))
        asked = heard(robot, pulse, by_festival("points the beer"))
        assert not asked["accepted"], robot.of("utterance")[-2:]
        robot.wait_for(lambda e: e["type"] == "reply" and e["text"] == "did you say point beer?")
        assert robot.of("selected_object") == []
        answered = heard(robot, pulse, by_festival("yes"))
        assert (answered["text"], answered["obeyed"]) == ("point beer", True)
        selected = robot.wait_for(lambda event: event["type"] == "selected_object").event
        assert selected["value"] == 1
