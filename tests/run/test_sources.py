"""From utterances to events: what is sent when, and what is sent last."""

from __future__ import annotations

import itertools
import json
from collections.abc import Sequence
from pathlib import Path

import pytest
from driving import COMMANDS, STARTED, STOPPED, speak, type_lines
from hypothesis import given
from hypothesis import strategies as st
from language.template_texts import commands_of
from recordings import FIXTURES, Recording

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
from voz.inbox import Inbox
from voz.run.sources import MAX_REFUSED_PER_SECOND, TextCommands, read_text, typed_items
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


LIST = """
stop: [please] stop
stop speech
go forward
turn: turn {side} {angle: 5..180 by 5} degrees
side = left | right
"""


class Typing:
    """Texts that are taken, and the time at which, s."""

    def __init__(self) -> None:
        self.now = 5.0
        self.inbox = Inbox({"stop", "stop speech"})
        commands = commands_of(LIST)
        self.texts = TextCommands(lambda: commands, self.inbox, lambda: self.now)

    def taken(self) -> list[Utterance]:
        """All that waits, what stops first."""
        messages = []
        while (message := self.inbox.take(0)) is not None:
            assert isinstance(message, Utterance)
            messages.append(message)
        return messages


@pytest.mark.parametrize("text", ["help", "Help!", " ?", "commands", "Commands ?"])
def test_who_types_help_asks_what_may_be_said(text: str) -> None:
    typing = Typing()
    typing.texts.take(text)
    (said,) = typing.taken()
    assert (said.command, said.accepted, said.slots) == ("?", True, {})


def test_help_is_a_command_of_its_own_where_the_list_has_it_and_a_stop_is_one_always() -> None:
    own = commands_of("help: help [me]\nstop")
    found = read_text("Help me.", own, {"stop"})
    assert found
    assert found.command == "help"
    for text in ("help stop", "stop?"):
        stop = read_text(text, own, {"stop"})
        assert stop
        assert stop.command == "stop"
    assert read_text("help you", own, {"stop"}) is None


def test_a_stop_behind_thousands_of_other_lines_comes_first_and_most_are_counted() -> None:
    typing = Typing()
    for _ in range(3000):
        typing.texts.take("what is all this nonsense")
    typing.texts.take("stop")
    stop, *others = typing.taken()
    assert (stop.text, len(others)) == ("stop", MAX_REFUSED_PER_SECOND)
    assert typing.inbox.dropped == 3000 - MAX_REFUSED_PER_SECOND


@given(st.lists(st.tuples(st.floats(0, 0.5), st.sampled_from(["go forward", "nonsense"]))))
def test_no_command_is_dropped_and_of_other_texts_not_more_come_than_there_is_time_for(
    texts: list[tuple[float, str]],
) -> None:
    typing, refused, taken = Typing(), list[float](), list[Utterance]()
    for pause, text in texts:
        typing.now += pause
        typing.texts.take(text)
        taken += typing.taken()
    assert sum(one.accepted for one in taken) == sum(text == "go forward" for _, text in texts)
    assert len(taken) + typing.inbox.dropped == len(texts)
    refused = [one.t for one in taken if not one.accepted]
    assert all(
        later - first >= 1
        for first, later in zip(refused, refused[MAX_REFUSED_PER_SECOND:], strict=False)
    )


def test_what_is_no_command_says_which_was_meant_and_where_it_comes_from() -> None:
    typing = Typing()
    for text in ("go forwart", " ", "-", "Turn left 90 degrees."):
        typing.texts.take(text, "/heard")
    refused, turn = typing.taken()
    assert (refused.reason, refused.meant, refused.source) == (
        "not_a_command", "go forward", "/heard",
    )  # fmt: skip
    assert (turn.command, turn.slots) == ("turn", {"side": "left", "angle": 90})


@pytest.mark.parametrize(
    ("text", "command"),
    [
        ("stop stop stop", "stop"),
        ("Stop now!", "stop"),
        ("robot stop", "stop"),
        ("Hey robot, please stop.", "stop"),
        ("don't stop", "stop"),  # it stops for nothing rather than not
        ("go forward, stop", "stop"),
        ("nonsense " * 100 + "stop", "stop"),
        ("stop speech, please", "stop speech"),
        ("unstoppable", None),
        ("go forward please", None),
        ("stop", "stop"),
    ],
)
def test_what_has_the_words_of_a_stop_stops_and_nothing_else_is_guessed(
    text: str, command: str | None
) -> None:
    typing = Typing()
    for _ in range(MAX_REFUSED_PER_SECOND + 1):
        typing.texts.take("nonsense")
    typing.taken()
    typing.texts.take(text)
    assert [one.command for one in typing.taken()] == ([command] if command else [])


def test_stop_stops_whatever_the_list_calls_it() -> None:
    commands = commands_of("alto: alto [ya]\nadelante")
    for text, command in (("alto", "alto"), ("stop", "stop"), ("please stop", "stop")):
        parse = read_text(text, commands, {"alto", "stop"})
        assert parse is not None
        assert parse.command == command


def test_a_stop_is_known_without_its_accents() -> None:
    commands = commands_of("deténte\nsigue adelante")
    parse = read_text("oye, DETENTE ya", commands, {"deténte"})
    assert parse is not None
    assert parse.command == "deténte"


@pytest.mark.parametrize(
    ("text", "continues"),
    [
        ("go", True),
        ("Please", True),
        ("turn left", True),
        ("turn left 90", True),
        ("g", False),
        ("go forward", False),
        ("turn left 91", False),
        ("", False),
        (".", False),
        ("stop", False),  # `stop speech` goes on with it, but the robot is to stop
        ("please stop", False),
    ],
)
def test_a_space_goes_on_with_what_a_longer_command_begins_with(text: str, continues: bool) -> None:
    assert Typing().texts.continues(text) == continues
