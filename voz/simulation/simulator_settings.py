"""The settings of the simulated robot and its room."""

from __future__ import annotations

from typing import Annotated

import msgspec

from voz.errors import ConfigError
from voz.settings import Section
from voz.simulation.room import Tabletop, gap_to_table, gap_to_walls

Meters = Annotated[float, msgspec.Meta(ge=0, le=100)]
Length = Annotated[float, msgspec.Meta(ge=0.1, le=100)]  # thinner, and a robot drives through it
Angle = Annotated[float, msgspec.Meta(ge=-6.3, le=6.3)]
Rate = Annotated[float, msgspec.Meta(ge=0.01, le=10)]
Seconds = Annotated[float, msgspec.Meta(ge=0.01, le=60)]


class Simulator(Section, frozen=True, kw_only=True):
    """The simulated robot and its room, whose corner is the origin.

    Attributes:
        room: its length along x and along y, m.
        start: where the robot is at first, x and y in m and its heading in rad.
        table: x and y of its corner nearest to the origin, its size along x and along y, m.
        table_height: of its top, m.
        beer: where on the table it stands, x and y, m.
        cocacola: the same.
        radius: of the robot, m.
        max_linear: limit of its own on the velocity, m/s.
        max_angular: the same, rad/s.
        linear_acceleration: how fast the velocity changes at most, m/s².
        angular_acceleration: the same, rad/s².
        time_constant: how long the velocity lags behind the one asked for, s.
        cmd_vel_timeout: it stops when no velocity came for so long, s.
        arm_speed: how fast a joint of the arm turns, rad/s.
    """

    room: tuple[Length, Length] = (2.6, 1.8)
    start: tuple[Meters, Meters, Angle] = (0.7, 0.6, 0.0)
    table: tuple[Meters, Meters, Length, Length] = (1.5, 1.35, 0.9, 0.45)
    table_height: Meters = 0.7
    beer: tuple[Meters, Meters] = (1.7, 1.5)
    cocacola: tuple[Meters, Meters] = (2.2, 1.5)
    radius: Annotated[float, msgspec.Meta(ge=0.05, le=5)] = 0.17
    max_linear: Rate = 1.0
    max_angular: Rate = 2.0
    linear_acceleration: Rate = 0.5
    angular_acceleration: Rate = 2.0
    time_constant: Seconds = 0.15
    cmd_vel_timeout: Seconds = 0.5
    arm_speed: Rate = 2.5

    def __post_init__(self) -> None:
        """Raise ConfigError if the robot starts in a wall, or objects are not on the table."""
        super().__post_init__()
        table, (x, y, _) = Tabletop(*self.table), self.start
        if table.x + table.width > self.room[0] or table.y + table.depth > self.room[1]:
            raise ConfigError("the table is not within the room")
        for name, place in (("beer", self.beer), ("cocacola", self.cocacola)):
            if not table.holds(*place):
                raise ConfigError(f"the {name} is not on the table")
        if gap_to_walls(x, y, self.radius, self.room) < 0:
            raise ConfigError("at its start the robot is in a wall")
        if gap_to_table(x, y, self.radius, table) < 0:
            raise ConfigError("at its start the robot is in the table")
