from __future__ import annotations

from typing import Any

import pytest


@pytest.mark.parametrize(
    ("said", "heard", "right", "accepted", "refused", "wrong"),
    [
        ("stop", ["stop"], True, True, False, False),
        ("stop", ["stop?"], True, False, True, False),
        ("stop", ["go back"], False, False, False, True),
        ("stop", ["go back?"], False, False, True, False),
        ("stop", [], False, False, False, False),
        ("stop", ["stop", "stop"], False, False, False, False),
        ("stop", ["?", "stop"], True, True, False, False),
        ("stop", ["go back?", "stop"], True, True, False, False),
        ("stop", ["go back?", "stop?"], False, False, True, False),
        ("stop", ["go back", "stop?"], False, False, False, True),
    ],
)
def test_what_a_command_was_taken_for(
    said: str,
    heard: list[str],
    right: bool,
    accepted: bool,
    refused: bool,
    wrong: bool,
    result: Any,
) -> None:
    made = result(said, *heard)
    assert made.is_right == right
    assert made.is_right_and_accepted == accepted
    assert made.is_refused == refused
    assert made.is_wrongly_obeyed == wrong


def test_of_a_long_recording_all_commands_must_be_heard_in_their_order(result: Any) -> None:
    said = "stop | go back"
    assert result(said, "stop", "go back", kind="long").is_right_and_accepted
    assert not result(said, "go back", "stop", kind="long").is_right
    assert not result(said, "stop", "go back?", kind="long").is_right_and_accepted


def test_whatever_a_near_miss_makes_the_robot_do_is_wrong(result: Any) -> None:
    assert result("stop it", "stop", kind="near-miss").is_wrongly_obeyed
    assert not result("stop it", "stop?", kind="near-miss").is_wrongly_obeyed
