from __future__ import annotations

import io
import re
from types import SimpleNamespace

import pytest
from rich.console import Console, RenderableType

from voz.events import SelectedObject, Twist
from voz.robot.drawing import room_view
from voz.robot.drawing.room_view import RoomView, TripView
from voz.robot.simulator import SimulatedRobot, Trip
from voz.simulation.simulator_settings import Simulator
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
    sound = SimpleNamespace(peak=0.1, background=-60.0, deaf=False, device="USB Audio")
    display = Display(
        sound, SimpleNamespace(listening=True, name="", awake=True), lambda: "", extra=room
    )
    lines = shown(display, width, 40)
    assert any(re.search("USB Audio.*[\u2801-\u28ff]", line) for line in lines) == beside
    assert any(re.search("[\u2801-\u28ff]", line) for line in lines)
    assert len(lines) <= 40
