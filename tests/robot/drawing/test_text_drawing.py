from __future__ import annotations

import io

import pytest
from hypothesis import given
from hypothesis import strategies as st
from msgspec.structs import replace
from rich.console import Console

from voz.robot.drawing.text_drawing import ARM, BODY, RAY, WALL, WAY, draw_in_text
from voz.robot.simulator import Trip
from voz.simulation.arm import Joints
from voz.simulation.kinematics import Pose2D
from voz.simulation.simulator_settings import Simulator
from voz.simulation.world import WorldState, start

ROOM = Simulator()
EXPECTED = [
    "⡏⠉⠉⠉⠉⠉⠉⠉⠉⠉⠉⠉⠉⠉⢹⠉⠉⠉⠉⠉⠉⠉⠉⢹⠉⢹",
    "⡇             ⢸ B    C ⢸ ⢸",
    "⡇             ⠘⠒⠒⠒⠒⠒⠒⠒⠒⠚ ⢸",
    "⡇                        ⢸",
    "⡇                        ⢸",
    "⡇    ⣴⣋⣙⣦                ⢸",
    "⡇    ⠹⢤⡠⠞                ⢸",
    "⡇                        ⢸",
    "⣇⣀⣀⣀⣀⣀⣀⣀⣀⣀⣀⣀⣀⣀⣀⣀⣀⣀⣀⣀⣀⣀⣀⣀⣀⣸",
]
coordinates = st.floats(0.17, 1.6)


def cells_of(
    style: str, state: WorldState, way: list[WorldState], width: int, height: int
) -> set[tuple[int, int]]:
    """Columns and rows of the characters that have a style."""
    text = draw_in_text(ROOM, state, way, width, height)
    found = set()
    for span in text.spans:
        if span.style == style:
            before = text.plain[: span.start]
            row = before.count("\n")
            found.add((span.start - (before.rfind("\n") + 1), row))
    return found


def test_a_small_room_looks_like_this() -> None:
    text = draw_in_text(ROOM, start(ROOM), [], 26, 9)
    assert text.plain.splitlines() == EXPECTED


@given(
    st.builds(Pose2D, coordinates, coordinates, st.floats(-3.2, 3.2)),
    st.builds(Joints, st.floats(-3, 3), st.floats(-3, 3), st.floats(-3, 3)),
    st.sampled_from((1, 2, 100, 7)),
    st.integers(1, 120),
    st.integers(1, 50),
)
def test_it_is_as_large_as_it_is_asked_to_be(
    pose: Pose2D, arm: Joints, selected: int, width: int, height: int
) -> None:
    state = WorldState(0.0, pose, arm=arm, selected=selected)
    lines = draw_in_text(ROOM, state, [state], width, height).plain.split("\n")
    assert len(lines) == height
    assert all(len(line) == width for line in lines)


def test_the_robot_is_where_it_is_and_the_way_behind_it() -> None:
    state = replace(start(ROOM), pose=Pose2D(1.3, 0.9, 0.0))
    way = [replace(state, pose=Pose2D(x / 100, 0.9, 0.0)) for x in range(30, 130)]
    body = cells_of(BODY, state, way, 53, 18)
    # 40 dots for a meter: 20 characters across, 10 down.
    columns, rows = {column for column, _ in body}, {row for _, row in body}
    assert (min(columns), max(columns)) == pytest.approx((23, 29), abs=1)
    assert (min(rows), max(rows)) == pytest.approx((7, 10), abs=1)
    behind = cells_of(WAY, state, way, 53, 18)
    assert {row for _, row in behind} <= {8, 9}
    assert min(column for column, _ in behind) == pytest.approx(6, abs=1)
    assert cells_of(WALL, state, way, 53, 18) >= {(0, 0), (51, 0), (0, 17)}


def test_an_arm_that_points_reaches_out_and_a_thin_line_goes_on_to_the_object(tour: Trip) -> None:
    folded = tour.states[0]
    pointing = next(s for s in reversed(tour.states) if s.selected == 2)
    assert not cells_of(RAY, folded, [], 60, 20)
    assert len(cells_of(RAY, pointing, [], 60, 20)) > 3
    assert len(cells_of(ARM, pointing, [], 60, 20)) > len(cells_of(ARM, folded, [], 60, 20))


def test_a_terminal_shows_it_as_it_is(tour: Trip) -> None:
    text = draw_in_text(ROOM, tour.states[-1], tour.states, 40, 12)
    console = Console(file=io.StringIO(), width=40)
    console.print(text)
    assert isinstance(console.file, io.StringIO)
    assert console.file.getvalue().rstrip("\n") == text.plain
    assert "B" in text.plain
    assert "C" in text.plain
