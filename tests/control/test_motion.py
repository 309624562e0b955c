"""What each change does to the velocities, at its smallest too."""

from __future__ import annotations

import pytest

from voz.control.motion import Mode, Motion, apply_step, faster, rotate, slower, turn
from voz.control.steps import Step

TURNING, ROTATING = Mode.TURNING, Mode.ROTATING


@pytest.mark.parametrize(
    ("before", "angular", "after"),
    [
        (Motion(5, 1, TURNING), 1, Motion(5, 2, TURNING)),
        (Motion(5, -1, TURNING), -1, Motion(5, -2, TURNING)),
        (Motion(5, 1, TURNING), -1, Motion(5, -1, TURNING)),
        (Motion(0, 1, ROTATING), 1, Motion(0, 1, TURNING)),
        (Motion(5, 1, TURNING), 0, Motion(5, 0, TURNING)),
    ],
)
def test_a_turn_to_the_same_side_gets_tighter(before: Motion, angular: int, after: Motion) -> None:
    assert turn(before, angular) == after


@pytest.mark.parametrize(
    ("before", "angular", "after"),
    [
        (Motion(5, 1), 1, Motion(0, 1)),
        (Motion(5, 1, TURNING), 2, Motion(0, 2, ROTATING)),
        (Motion(0, 1, ROTATING), -1, Motion(0, -1, ROTATING)),
        (Motion(0, 1, ROTATING), 2, Motion(0, 1, ROTATING)),
        (Motion(0, 1, ROTATING), 0, Motion(0, 0, ROTATING)),
    ],
)
def test_a_rotation_to_the_same_side_goes_on(before: Motion, angular: int, after: Motion) -> None:
    assert rotate(before, angular) == after


@pytest.mark.parametrize("sign", [1, -1])
def test_the_least_velocity_has_a_side_too(sign: int) -> None:
    assert faster(Motion(sign), 50) == Motion(51 * sign)
    assert slower(Motion(sign), 50) == Motion(-49 * sign)
    assert faster(Motion(0, sign, ROTATING), 50) == Motion(0, 51 * sign, ROTATING)


def test_a_step_without_a_velocity_changes_none() -> None:
    assert apply_step(Motion(5, 1, TURNING), Step(say="well")) == Motion(5, 1, TURNING)
