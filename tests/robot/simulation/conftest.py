"""Trips to draw: typed commands, driven through the room in no time."""

from __future__ import annotations

from collections.abc import Callable, Sequence

import pytest
from driving import type_lines

from voz.robot.simulation.simulator import SimulatedRobot, Trip
from voz.settings import Simulator

Driver = Callable[..., Trip]


def drive(lines: Sequence[str], settings: Simulator | None = None) -> Trip:
    """The trip that typed commands make, a line in each 0.1 s."""
    robot = SimulatedRobot(settings or Simulator())
    type_lines(["start speech", *lines], robot.receive)
    robot.come_to_rest()
    return robot.trip()


@pytest.fixture(scope="session")
def driven() -> Driver:
    return drive


@pytest.fixture(scope="session")
def tour() -> Trip:
    """Forward, an arc to the left, a stop, both objects, the arm folded, and into the wall."""
    parts = [("go forward", 40), ("turn left", 40), ("stop", 5), ("point beer", 20)]
    parts += [("point cocacola", 20), ("fold arm", 15), ("go back", 200), ("stop", 0)]
    return drive([line for command, wait in parts for line in [command, *["-"] * wait]])


@pytest.fixture(scope="session")
def short(driven: Driver) -> Trip:
    """Two seconds, one command on the way."""
    return driven(["go forward", *["-"] * 14])
