"""What passes to the controller: what overtakes, and what may be lost."""

from __future__ import annotations

import pytest

from voz.control.messages import (
    End,
    Halt,
    Message,
    Rehearsal,
    Renewal,
    may_be_dropped,
    overtakes,
    too_late,
)
from voz.events import Notice, Partial, ProgramEnded, Utterance

HALTS = {"stop", "stop speech"}


def said(text: str, accepted: bool = True) -> Utterance:
    return Utterance(0, text, 0.9, accepted, 0, 0, "microphone")


@pytest.mark.parametrize(
    ("message", "first", "dropped"),
    [
        (said("stop"), True, True),
        (said("stop speech"), True, True),
        (said("stop", accepted=False), False, True),
        (said("go back"), False, True),
        (Partial(0, "stop", 0.9), True, True),
        (Partial(0, "halt", 0.9, command="stop"), True, True),
        (Partial(0, "go back", 0.9), False, True),
        (Notice(0, ""), False, True),
        (ProgramEnded(0, "dance"), False, True),
        (Halt(), True, True),
        (Rehearsal(on=False), True, False),
        (Renewal("", 0.0, under_way=True), True, False),
        (End(), True, False),
    ],
)
def test_what_stops_overtakes_and_what_changes_the_run_is_never_lost(
    message: Message, first: bool, dropped: bool
) -> None:
    assert overtakes(message, HALTS) == first
    assert may_be_dropped(message) == dropped


def test_a_command_that_is_too_late_says_so_and_nothing_else_does() -> None:
    late = too_late(said("go back"))
    assert isinstance(late, Utterance)
    assert (late.text, late.ignored) == ("go back", "too_late")
    for other in (said("go back", accepted=False), Partial(0, "go back", 0.9), Halt(), End()):
        assert too_late(other) is other
