from __future__ import annotations

import io
import re
from types import SimpleNamespace

import pytest
from hypothesis import given
from hypothesis import strategies as st
from msgspec.structs import replace
from rich.console import Console, RenderableType

from voz.events import SelectedObject, Twist
from voz.robot.simulation import room_view
from voz.robot.simulation.room_view import (
    ARM,
    BODY,
    RAY,
    WALL,
    WAY,
    RoomView,
    TripView,
    draw_in_text,
)
from voz.robot.simulation.simulator import SimulatedRobot, Trip
from voz.robot.simulation.world import Joints, Pose2D, WorldState, start
from voz.settings import Simulator
from voz.terminal.display import Display


def shown(what: RenderableType, width: int, height: int) -> list[str]:
    text = io.StringIO()
    Console(file=text, width=width, height=height, color_system=None).print(what)
    return [line.rstrip() for line in text.getvalue().splitlines()]


def test_a_trip_fits_the_terminal_and_takes_no_more_lines_than_it_needs(tour: Trip) -> None:
    large = shown(TripView(tour), 200, 100)
    assert max(map(len, large)) <= room_view.MAX_VIEW_WIDTH
    assert len(large) == round(room_view.MAX_VIEW_WIDTH * 2 * 1.8 / 2.6 / 4) + 1
    small = shown(TripView(tour), 80, 24)
    assert len(small) == 24 - room_view.FREE_LINES
    assert "B" in "".join(small)


def test_the_room_shows_where_the_robot_is_by_now(monkeypatch: pytest.MonkeyPatch) -> None:
    clock = 100.0
    monkeypatch.setattr(room_view.time, "monotonic", lambda: clock)
    robot = SimulatedRobot(Simulator())
    room = RoomView(robot, Simulator())
    before = shown(room, 80, 30)
    for cycle in range(20):
        clock = 100 + cycle / 10
        for receive in (robot.receive, room.receive):
            receive(Twist(cycle / 10, 0.1, 0.0))
    then = shown(room, 80, 30)
    assert then != before
    clock += 0.3  # nothing came since; the robot drives on
    assert shown(room, 80, 30) != then


def test_looking_changes_nothing_of_the_run() -> None:
    runs = []
    for looks in (False, True):
        robot = SimulatedRobot(Simulator())
        room = RoomView(robot, Simulator())
        for cycle in range(30):
            robot.receive(Twist(cycle / 10, 0.2, 0.3))
            room.receive(Twist(cycle / 10, 0.2, 0.3))
            if looks:
                shown(room, 80, 30)
        robot.receive(SelectedObject(3, 1))
        robot.come_to_rest()
        runs.append(robot.trip())
    assert runs[0] == runs[1]


@pytest.mark.parametrize(("width", "beside"), [(140, True), (80, False)])
def test_in_a_wide_terminal_it_is_beside_the_display_else_below(width: int, beside: bool) -> None:
    room = RoomView(SimulatedRobot(Simulator()), Simulator())
    sound = SimpleNamespace(peak=0.1, background=-60.0, speaking=False, device="USB Audio")
    display = Display(
        sound, SimpleNamespace(listening=True, name="", awake=True), lambda: "", extra=room
    )
    lines = shown(display, width, 40)
    assert any(re.search("USB Audio.*[\u2801-\u28ff]", line) for line in lines) == beside
    assert any(re.search("[\u2801-\u28ff]", line) for line in lines)
    assert len(lines) <= 40


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
