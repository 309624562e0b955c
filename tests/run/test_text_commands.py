"""What is typed, or comes from another recognizer, on its way to the loop."""

from __future__ import annotations

import pytest
from hypothesis import given
from hypothesis import strategies as st
from language.template_texts import commands_of

from voz.events import Utterance
from voz.inbox import Inbox
from voz.run.sources import read_text
from voz.run.text_commands import MAX_REFUSED_PER_SECOND, TextCommands

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
