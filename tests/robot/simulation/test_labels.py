from __future__ import annotations

from typing import Any

import pytest

from voz.robot.simulation.labels import (
    MAX_NUMBERED_MARKS,
    distance,
    pointings,
    same_place,
    seconds_between,
    time_marks,
)
from voz.robot.simulation.simulator import Trip, TripMark


def test_the_length_of_the_way_is_what_was_driven(driven: Any) -> None:
    there_and_back = driven(["go forward", *["-"] * 49, "go back", *["-"] * 49, "stop"])
    # 10 s at 0.1 m/s, without the moment in which it turns round.
    assert distance(there_and_back.states) == pytest.approx(1.0, abs=0.05)
    assert distance(driven(["rotate left", "-", "stop"]).states) == 0


def test_there_is_a_mark_each_second_while_it_drives(driven: Any) -> None:
    trip = driven([*["-"] * 30, "go forward", *["-"] * 59, "stop", *["-"] * 50])
    marks = time_marks(trip.states)
    assert [mark.t for mark in marks] == [4, 5, 6, 7, 8, 9]
    assert [mark.text for mark in marks] == ["4 s", "", "6 s", "", "8 s", ""]
    assert seconds_between(marks) == 1
    for mark in marks:
        assert mark.x == pytest.approx(0.7 + 0.1 * (mark.t - 3.1), abs=0.03)


def test_a_long_way_has_fewer_marks(driven: Any) -> None:
    trip = driven(["turn left", *["-"] * 3000, "go forward", "turn left", *["-"] * 3000])
    numbers = [mark for mark in time_marks(trip.states) if mark.text]
    assert 2 <= len(numbers) <= MAX_NUMBERED_MARKS + 1


def test_what_stands_still_has_no_marks(driven: Any) -> None:
    assert time_marks(driven(["-"] * 30).states) == []
    assert time_marks(driven(["rotate left", *["-"] * 30]).states) == []
    assert seconds_between([]) == 0


def test_what_is_said_in_one_place_is_together() -> None:
    said = [TripMark(t, x, 0.0, "go") for t, x in enumerate((0.0, 0.01, 0.5, 0.01, 0.0))]
    assert same_place(said) == [said[:2], said[2:3], said[3:]]
    assert same_place([]) == []


def test_the_arm_points_at_each_object_last_before_it_is_told_another(tour: Trip) -> None:
    beer, cocacola = pointings(tour)
    assert (beer.selected, cocacola.selected) == (1, 2)
    assert beer.t < cocacola.t
    assert beer.arm != cocacola.arm


def test_an_arm_that_had_no_time_to_point_does_not(driven: Any) -> None:
    assert pointings(driven(["point beer", "-", "fold arm", *["-"] * 30])) == []
