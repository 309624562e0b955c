"""Every pair of losses, at each door of a live run: the first stops it, and nothing releases it.

As PX4 tests its failsafe: in a time of its own, so that all pairs are affordable.
"""

from __future__ import annotations

import itertools
from dataclasses import dataclass

import pytest
from promises.doors import DOORS, LiveDoor
from promises.promises import METERS, say
from promises.run import Do, Given, Outcome

LOST_AT = 5.0
"""When the first is lost, s; the second follows, and the first comes back while it lasts."""

STALL = 1.0
"""Of a process that is held up, s; `Live` has it, too."""

SOON = 0.5
"""So soon it stands, s."""


@dataclass(frozen=True)
class Loss:
    """Something that ends a motion, and how it is over, if it can be."""

    lost: str
    found: str = ""

    def __str__(self) -> str:
        return self.lost


LOSSES = (
    Loss("lose the robot", "find the robot"),
    Loss("lose the page", "find the page"),
    Loss("close the page"),
    Loss("lose the microphone", "find the microphone"),
    Loss("mute the microphone", "unmute the microphone"),
    Loss("lose the recognizer", "find the recognizer"),
    Loss("save the list", "use the list"),
    Loss("stall"),
    Loss("press space"),
)

CONCERNS = {
    "the page": ("hands-free page", "held button", "tap, by WebSocket", "tap, by POST"),
    "the microphone": ("own microphone",),
}
"""What is lost for some doors alone; another run has no such thing."""

LIVE = [door for door in DOORS if isinstance(door, LiveDoor)]


def concerns(loss: Loss, door: LiveDoor) -> bool:
    """Whether a run by this door has what is lost."""
    return all(door.name in doors for thing, doors in CONCERNS.items() if thing in loss.lost)


def losses_at(door: LiveDoor) -> list[Loss]:
    """The losses of a run by a door."""
    return [loss for loss in LOSSES if concerns(loss, door)]


def script(first: Loss, second: Loss, after: float) -> list[Do]:
    """Lose one thing, then another; the first is back while the second lasts, then that is."""
    done = [
        Do(LOST_AT, first.lost),
        Do(LOST_AT + after, second.lost),
        Do(LOST_AT + 3, first.found),
        Do(LOST_AT + 6, second.found),
    ]
    return [say(1, "run fast"), *(do for do in done if do.what)]


def check(outcome: Outcome, stalls: bool) -> None:
    """Check what came of two losses, one of which is perhaps a stall before it stands.

    It moved until the first loss, stands soon after it, and goes on to stand."""
    assert outcome.error is None
    assert outcome.moving(LOST_AT - 0.3, LOST_AT), "it did not move before"
    held_up = LOST_AT + STALL if stalls else LOST_AT  # then nothing is sent: see the watchdogs
    stood = outcome.stood_at(held_up)
    assert stood <= held_up + SOON, f"it moves until {stood:g} s"
    assert outcome.meters(held_up, held_up + 10) <= METERS + 1e-9


SOUND_OF_A_PAGE = [door for door in LIVE if door.browser_listens and door.spoken]


@pytest.mark.parametrize("door", SOUND_OF_A_PAGE, ids=str)
def test_the_sound_of_a_page_that_does_not_answer_moves_nothing_that_stands(door: LiveDoor) -> None:
    """It counts as gone after .35 s; others may drive after 3 s."""
    heard = door.run(Given(), [say(1.5, "go forward")], 4)
    assert heard.obeyed == ["go forward"]
    outcome = door.run(Given(), [Do(1, "silence the page"), say(1.5, "go forward")], 4)
    assert outcome.error is None
    assert outcome.obeyed == []
    assert outcome.moving(0) == []


PAIRS = [(door, first) for door in LIVE if door.watched for first in losses_at(door)]


@pytest.mark.parametrize(("door", "first"), PAIRS, ids=str)
def test_the_first_of_two_losses_stops_it_and_neither_releases_it(
    door: LiveDoor, first: Loss
) -> None:
    for second, after in zip(losses_at(door), itertools.cycle((0.0, 0.2, 1.0)), strict=False):
        if first.lost == second.lost == "stall":
            continue  # which is one
        outcome = door.run(Given(), script(first, second, after), LOST_AT + 8)
        try:
            check(outcome, first.lost == "stall" or (second.lost == "stall" and after < SOON))
        except AssertionError as wrong:
            pytest.fail(f"{first.lost}, then {second.lost} {after:g} s later: {wrong}")
