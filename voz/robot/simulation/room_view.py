"""The simulated room in a terminal, during a run or after it, in braille dots."""

from __future__ import annotations

import time
from collections import deque
from collections.abc import Sequence
from math import ceil, cos, hypot, pi, sin

from rich.console import Console, ConsoleOptions, RenderResult
from rich.text import Text

from voz.events import Event, Twist
from voz.robot.simulation.simulator import SimulatedRobot, Trip
from voz.robot.simulation.world import WorldState, arm_points, place_of
from voz.settings import Simulator

DOT_COLUMNS, DOT_ROWS = 2, 4
"""Dots in a character, about equally far apart across and down."""

BRAILLE = 0x2800
"""The character without a dot."""

BRAILLE_BITS = ((0x01, 0x08), (0x02, 0x10), (0x04, 0x20), (0x40, 0x80))
"""What each dot adds to it, by row and column."""

WALL, TABLE, WAY, BODY = "dim", "yellow", "blue", "bold cyan"
ARM, RAY = "bold magenta", "magenta"
OBJECT_LETTERS = (("B", "bold yellow"), ("C", "bold red"))

RAY_EVERY = 3.0
"""Distance of the dots in the line to what the arm points at, in dots."""

CIRCLE_DOTS = 90
"""Dots around the base."""

MAX_DRAWN_STATES = 2000
"""Places of a way that are drawn; more cannot be distinguished."""


class Dots:
    """Dots of different styles; each character has the style of its last dot."""

    def __init__(self, width: int, height: int, room: tuple[float, float]) -> None:
        """Choose the scale so that a room, m, fits into so many characters."""
        self._size = width, height
        across, down = width * DOT_COLUMNS - 1, height * DOT_ROWS - 1
        self._per_meter = min(across / room[0], down / room[1])
        self._top = round(room[1] * self._per_meter)
        self._bits: dict[tuple[int, int], int] = {}
        self._styles: dict[tuple[int, int], str] = {}
        self._letters: dict[tuple[int, int], str] = {}

    def dot(self, x: float, y: float, style: str) -> None:
        """Draw a dot at a place, m; outside of the drawing nothing is drawn."""
        cell, row, column = self._cell(x, y)
        self._bits[cell] = self._bits.get(cell, 0) | BRAILLE_BITS[row][column]
        self._styles[cell] = style

    def line(
        self, start: Sequence[float], end: Sequence[float], style: str, every: float = 1.0
    ) -> None:
        """Draw a line between two places, m, with `every` dots between drawn ones."""
        length = hypot(end[0] - start[0], end[1] - start[1])
        steps = max(1, ceil(length * self._per_meter / every))
        for step in range(steps + 1):
            share = step / steps
            x = start[0] + (end[0] - start[0]) * share
            self.dot(x, start[1] + (end[1] - start[1]) * share, style)

    def rectangle(self, x: float, y: float, width: float, depth: float, style: str) -> None:
        """Draw the edges of a rectangle, m."""
        for side in (0.0, 1.0):
            dx, dy = width * side, depth * side
            self.line((x + dx, y), (x + dx, y + depth), style)
            self.line((x, y + dy), (x + width, y + dy), style)

    def letter(self, x: float, y: float, letter: str, style: str) -> None:
        """Write a letter at a place, m, over the dots that are there."""
        cell, _, _ = self._cell(x, y)
        self._letters[cell] = letter
        self._styles[cell] = style

    def text(self) -> Text:
        """Return the drawing in lines of the same length."""
        width, height = self._size
        lines = (
            Text.assemble(*(self._character((column, row)) for column in range(width)))
            for row in range(height)
        )
        return Text("\n", no_wrap=True, end="").join(lines)

    def _cell(self, x: float, y: float) -> tuple[tuple[int, int], int, int]:
        across, down = round(x * self._per_meter), self._top - round(y * self._per_meter)
        return (across // DOT_COLUMNS, down // DOT_ROWS), down % DOT_ROWS, across % DOT_COLUMNS

    def _character(self, cell: tuple[int, int]) -> tuple[str, str]:
        dots = chr(BRAILLE + self._bits[cell]) if cell in self._bits else " "
        return self._letters.get(cell, dots), self._styles.get(cell, "")


def draw_in_text(
    settings: Simulator, state: WorldState, way: Sequence[WorldState], width: int, height: int
) -> Text:
    """Draw the room from above, in `height` lines of `width` characters.

    The robot is now in `state`, and was before in those of `way`.
    """
    dots = Dots(width, height, settings.room)
    dots.rectangle(0, 0, *settings.room, WALL)
    dots.rectangle(*settings.table, TABLE)
    for past in way[:: len(way) // MAX_DRAWN_STATES + 1]:
        dots.dot(past.pose.x, past.pose.y, WAY)
    _draw_robot(dots, state, settings)
    for (letter, style), place in zip(
        OBJECT_LETTERS, (settings.beer, settings.cocacola), strict=True
    ):
        dots.letter(*place, letter, style)
    return dots.text()


def _draw_robot(dots: Dots, state: WorldState, settings: Simulator) -> None:
    x, y, heading = state.pose
    radius = settings.radius
    for number in range(CIRCLE_DOTS):
        turn = 2 * pi * number / CIRCLE_DOTS
        dots.dot(x + radius * cos(turn), y + radius * sin(turn), BODY)
    dots.line((x, y), (x + radius * cos(heading), y + radius * sin(heading)), BODY)
    shoulder, elbow, hand = arm_points(state.pose, state.arm)
    target = place_of(state.selected, settings)
    if target:
        dots.line(hand, target, RAY, every=RAY_EVERY)
    dots.line(shoulder, elbow, ARM)
    dots.line(elbow, hand, ARM)


MAX_VIEW_WIDTH = 76
"""Characters; more shows no more of a room."""

FREE_LINES = 2
"""Lines of the terminal that stay free, for the cursor and what was typed last."""


class RoomView:
    """Draws where a simulated robot is now, and its way so far."""

    def __init__(self, robot: SimulatedRobot, settings: Simulator) -> None:
        """Begin with an empty way; the settings are those of the robot."""
        self.settings = settings  # the room
        self._robot = robot
        self._behind = 0.0  # from the events' time to the clock's, s
        self._way: deque[WorldState] = deque(maxlen=MAX_DRAWN_STATES)

    def receive(self, event: Event) -> None:
        """Learn the time of the run from the velocities."""
        if isinstance(event, Twist):
            self._behind = time.monotonic() - event.t

    def state(self) -> WorldState:
        """Return the state of the room now."""
        return self._robot.state_at(time.monotonic() - self._behind)

    def __rich_console__(self, console: Console, options: ConsoleOptions) -> RenderResult:
        state = self.state()
        self._way.append(state)
        yield _fitted(self.settings, state, self._way, options)


class TripView:
    """Draws what a simulated robot did."""

    def __init__(self, trip: Trip) -> None:
        """Take the trip to draw."""
        self._trip = trip

    def __rich_console__(self, console: Console, options: ConsoleOptions) -> RenderResult:
        trip = self._trip
        yield _fitted(trip.settings, trip.states[-1], trip.states, options)


def _fitted(
    settings: Simulator, state: WorldState, way: Sequence[WorldState], options: ConsoleOptions
) -> Text:
    """Draw the room as large as the terminal allows."""
    along_x, along_y = settings.room
    width = min(options.max_width, MAX_VIEW_WIDTH)
    needed = width * DOT_COLUMNS * along_y / along_x / DOT_ROWS
    height = min(round(needed) + 1, options.height or options.size.height - FREE_LINES)
    return draw_in_text(settings, state, list(way), width, max(1, height))
