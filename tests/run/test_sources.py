"""From utterances to events: what is sent when, and what is sent last."""

from __future__ import annotations

import itertools
import json
from collections.abc import Iterator, Sequence
from pathlib import Path

import numpy as np
import pytest
import soundfile
from driving import COMMANDS, STARTED, STOPPED, speak, type_lines
from hypothesis import given
from hypothesis import strategies as st
from language.template_texts import commands_of
from recordings import FIXTURES, GO_BACK, Recording

from voz.api.recognizer import Recognizer
from voz.events import (
    Event,
    Notice,
    Reply,
    SelectedObject,
    Twist,
    Utterance,
    to_json,
)
from voz.run.sources import typed_items
from voz.settings import Safety


def typed(lines: Sequence[str], safety: Safety | None = None) -> list[Event]:
    events: list[Event] = []
    type_lines(lines, events.append, safety=safety)
    return events


def spoken(recognizer: Recognizer, *paths: Path) -> tuple[list[Event], list[str]]:
    events: list[Event] = []
    return events, speak(recognizer, paths, events.append)


def velocities(events: list[Event]) -> list[tuple[float, float]]:
    return [(e.linear, e.angular) for e in events if isinstance(e, Twist)]


def of_type(events: list[Event], kind: type[Event]) -> list[Event]:
    return [e for e in events if isinstance(e, kind)]


def test_each_line_is_one_cycle_and_zero_is_sent_last() -> None:
    events = typed(["start speech", "go forward", "-", "", "turn left"])
    assert velocities(events) == [(0, 0), (0.1, 0), (0.1, 0), (0.1, 0), (0.1, 0.1), (0, 0)]
    assert [e.t for e in of_type(events, Twist)] == [0, 0.1, 0.2, 0.3, 0.4, 0.5]


def test_a_command_comes_before_the_velocity_it_causes() -> None:
    events = typed(["start speech", "point beer"])
    assert events == [
        Utterance(0.0, "start speech", 1.0, True, 0.0, 0.0, "text", obeyed=True),
        Reply(0.0, STARTED),
        Twist(0.0, 0.0, 0.0),
        Utterance(0.1, "point beer", 1.0, True, 0.1, 0.1, "text", obeyed=True),
        SelectedObject(0.1, 1),
        Twist(0.1, 0.0, 0.0),
        Twist(0.2, 0.0, 0.0),
    ]


def test_typed_text_is_normalized_and_unknown_text_is_not_accepted() -> None:
    events = of_type(typed(["  START   Speech\n", "open the door"]), Utterance)
    assert [(e.text, e.accepted, e.confidence) for e in events] == [
        ("start speech", True, 1.0),
        ("open the door", False, 0.0),
    ]


@given(st.lists(st.sampled_from([*COMMANDS, "-", "xyz"]), max_size=40))
def test_there_are_as_many_cycles_as_lines_and_the_last_is_zero(lines: list[str]) -> None:
    sent = velocities(typed(lines))
    assert len(sent) == len(lines) + 1
    assert sent[-1] == (0, 0)


def test_s6_a_robot_that_hears_nothing_stops_and_needs_a_new_command() -> None:
    lines = ["start speech", "go forward", *["-"] * 14, "speed up", "go back", "-"]
    events = typed(lines, Safety(motion_time_limit=1.0))
    moving = [velocity[0] for velocity in velocities(events)]
    assert moving[1:11] == [0.1] * 10
    assert moving[11:17] == [0.0] * 6
    assert moving[17:] == [-0.1, -0.1, 0.0]
    (warning,) = of_type(events, Notice)
    assert warning == Notice(1.1, "no command for 1 s: the robot stops", stops=True)


@pytest.mark.parametrize("end", [KeyboardInterrupt, SystemExit, RuntimeError])
def test_s7_zero_is_sent_last_whatever_ends_the_run(end: type[BaseException]) -> None:
    events: list[Event] = []

    def lines() -> Iterator[str]:
        yield "start speech"
        yield "go forward"
        raise end

    with pytest.raises(end):
        type_lines(lines(), events.append)
    assert velocities(events)[-2:] == [(0.1, 0.0), (0.0, 0.0)]


def test_a_spoken_session_drives_the_robot(recognizer: Recognizer, session: Recording) -> None:
    events, errors = spoken(recognizer, session.path)
    assert errors == []
    heard = [e.text for e in of_type(events, Utterance)]
    assert heard == session.commands
    sent = velocities(events)
    changes = [b for a, b in itertools.pairwise(sent) if a != b]
    assert changes == [(0.1, 0), (0.15, 0), (0.15, 0.1), (0, 0), (0, -0.1), (0, -0.15), (0, 0)]
    assert [e.value for e in of_type(events, SelectedObject)] == [1, 100]
    assert [e.text for e in of_type(events, Reply)] == [STARTED, STOPPED]


def test_events_are_in_the_order_of_time_and_cycles_are_even(
    recognizer: Recognizer, session: Recording
) -> None:
    events, _ = spoken(recognizer, session.path)
    times = [e.t for e in events]
    assert times == sorted(times)
    cycles = [e.t for e in of_type(events, Twist)]
    assert cycles == [i / 10 for i in range(len(cycles))]


def test_recordings_follow_each_other_in_one_stream_of_time(recognizer: Recognizer) -> None:
    clips = [
        FIXTURES / "commands" / f"festival_slt__{name}.flac"
        for name in ("start_speech", "go_forward", "stop")
    ]
    events, _ = spoken(recognizer, *clips)
    heard = of_type(events, Utterance)
    assert [e.text for e in heard] == ["start speech", "go forward", "stop"]
    spans = [t for e in heard for t in (e.start, e.end, e.t)]
    assert all(a <= b + 1e-9 for a, b in itertools.pairwise(spans))
    assert (0.1, 0.0) in velocities(events)
    assert velocities(events)[-2:] == [(0.0, 0.0), (0.0, 0.0)]


def test_a_command_at_the_very_end_still_takes_effect(recognizer: Recognizer) -> None:
    commands = FIXTURES / "commands"
    events, _ = spoken(
        recognizer, commands / "flite_slt__start_speech.flac", commands / "flite_slt__go_back.flac"
    )
    assert velocities(events)[-2:] == [(-0.1, 0.0), (0.0, 0.0)]


def test_an_unreadable_recording_is_a_warning_and_the_rest_is_obeyed(
    recognizer: Recognizer, session: Recording, tmp_path: Path
) -> None:
    bad = tmp_path / "bad.wav"
    bad.write_text("no recording")
    events, errors = spoken(recognizer, bad, session.path)
    (warning,) = of_type(events, Notice)
    assert [warning.text] == errors
    assert len(of_type(events, Utterance)) == len(session.commands)


def test_channels_out_of_phase_are_a_warning_and_obeyed(
    recognizer: Recognizer, tmp_path: Path
) -> None:
    sound, rate = soundfile.read(GO_BACK)
    soundfile.write(tmp_path / "a.wav", np.stack([sound, -sound], axis=1), rate)
    events, errors = spoken(recognizer, tmp_path / "a.wav")
    (warning,) = of_type(events, Notice)
    assert "its channels are out of phase" in warning.text
    assert errors == []
    assert [heard.text for heard in of_type(events, Utterance)] == ["go back"]


def test_typed_text_may_have_digits_and_says_what_it_means() -> None:
    commands = commands_of("turn: turn left [{angle: 5..180 by 5} degrees]\nstop")
    lines = ["Turn left 90 degrees.", "stop!", "turn left"]
    heard = [e for e in typed_items(lines, commands, {"stop"}) if isinstance(e, Utterance)]
    assert [(u.text, u.command, u.slots, u.accepted) for u in heard] == [
        ("turn left ninety degrees", "turn", {"angle": 90}, True),
        ("stop", "stop", {}, True),
        ("turn left", "turn", {}, True),
    ]
    first, second, _ = (json.loads(to_json(u)) for u in heard)
    assert (first["command"], first["slots"]) == ("turn", {"angle": 90})
    assert "command" not in second
    assert "slots" not in second
