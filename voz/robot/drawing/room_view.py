"""The simulated room in a terminal, during a run or after it."""

from __future__ import annotations

import time
from collections import deque
from collections.abc import Sequence

from rich.console import Console, ConsoleOptions, RenderResult
from rich.text import Text

from voz.events import Event, Twist
from voz.robot.drawing.text_drawing import DOT_COLUMNS, DOT_ROWS, MAX_DRAWN_STATES, draw_in_text
from voz.robot.simulator import SimulatedRobot, Trip
from voz.simulation.simulator_settings import Simulator
from voz.simulation.world import WorldState

MAX_VIEW_WIDTH = 76
"""Characters; more shows no more of a room."""

FREE_LINES = 2
"""Lines of the terminal that stay free, for the cursor and what was typed last."""


class RoomView:
    """Draws where a simulated robot is now, and its way so far.

    Attributes:
        settings: the room.
    """

    def __init__(self, robot: SimulatedRobot, settings: Simulator) -> None:
        """Begin with an empty way; the settings are those of the robot."""
        self.settings = settings
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
