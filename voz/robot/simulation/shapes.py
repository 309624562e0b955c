"""The shapes in the picture: the room, the robot and its arm. Needs matplotlib."""

from __future__ import annotations

from collections.abc import Sequence
from math import cos, sin
from typing import Any

from matplotlib.artist import Artist
from matplotlib.axes import Axes
from matplotlib.patches import Circle, Polygon, Rectangle
from matplotlib.ticker import MultipleLocator

from voz.robot.simulation.simulator import TripMark
from voz.robot.simulation.world import Pose2D, WorldState, arm_points, place_of
from voz.settings import Simulator

WAY, BODY, ARM, SAID, HIT = "#1f4e79", "#cfe0f3", "#c4560a", "#1d7044", "#b3001b"
WALL, FAINT = "#3c3c3c", "#888888"
WOOD: Any = {"facecolor": "#f1e6d3", "edgecolor": "#8a6d3b"}
OBJECT_COLORS = {"beer": "#f0b000", "cocacola": "#b3001b"}

DOT: Any = {"marker": "o", "ms": 4.5, "mfc": "white", "mec": WAY, "mew": 1.2}
"""A time mark."""

RAY: Any = {"lw": 1.4, "ls": (0, (4, 3))}
"""From the hand to what it points at."""

CROSS: Any = {"ls": "", "marker": "x", "ms": 9, "mew": 3, "color": HIT}
"""A collision."""

OBJECT_RADIUS = 0.04
"""Of a can, m."""


def draw_room(axes: Axes, settings: Simulator) -> list[Artist]:
    """Draw walls, table and objects; return what nothing else should cover."""
    width, depth = settings.room
    axes.add_patch(Rectangle((0, 0), width, depth, facecolor="#fbfbf9", edgecolor="none", zorder=0))
    axes.add_patch(
        Rectangle((0, 0), width, depth, fill=False, edgecolor=WALL, lw=4, clip_on=False, zorder=2)
    )
    x, y, along, across = settings.table
    axes.add_patch(Rectangle((x, y), along, across, lw=1.2, zorder=1, **WOOD))
    look: Any = {"textcoords": "offset points", "ha": "center"}
    corner = (x, y + across)
    things: list[Artist] = []
    axes.annotate("table", corner, (20, -5), va="top", color=WOOD["edgecolor"], **look)
    for name, place in (("beer", settings.beer), ("cocacola", settings.cocacola)):
        can = Circle(place, OBJECT_RADIUS, fc=OBJECT_COLORS[name], ec=WALL, lw=1.2, zorder=2)
        above = (place[0], place[1] + OBJECT_RADIUS)
        things.append(axes.annotate(name, above, (0, 3), va="bottom", zorder=2, **look))
        things.append(axes.add_patch(can))
    longest = max(settings.room)
    step = 0.5 if longest <= 6 else 2.0 if longest <= 25 else 10.0
    for axis in (axes.xaxis, axes.yaxis):
        axis.set_major_locator(MultipleLocator(step))
        axis.set_major_formatter("{x:g} m")
    axes.tick_params(length=0, colors="#666666", labelsize=8, pad=5)
    axes.set_frame_on(False)
    margin = 0.012 * longest  # else half of the walls' lines are cut
    axes.set(xlim=(-margin, width + margin), ylim=(-margin, depth + margin), aspect="equal")
    return things


def draw_outline(axes: Axes, pose: Pose2D, settings: Simulator) -> Artist:
    """Draw where the base was, as a dashed circle."""
    look: Any = {"edgecolor": FAINT, "ls": (0, (3, 2)), "lw": 1.2, "zorder": 2.5}
    return axes.add_patch(Circle((pose.x, pose.y), settings.radius, fill=False, **look))


def draw_robot(axes: Axes, pose: Pose2D, settings: Simulator) -> list[Artist]:
    """Draw the base, with an arrow in its direction."""
    radius, (x, y, heading) = settings.radius, pose
    body = Circle((x, y), radius, facecolor=BODY, edgecolor=WAY, lw=2, zorder=4)

    def at(length: float, aside: float) -> tuple[float, float]:
        direction = heading + aside
        return x + radius * length * cos(direction), y + radius * length * sin(direction)

    nose = Polygon([at(0.94, 0), at(0.52, 0.38), at(0.52, -0.38)], color=WAY, lw=0, zorder=4)
    return [axes.add_patch(body), axes.add_patch(nose)]


def draw_arm(
    axes: Axes, state: WorldState, settings: Simulator, alpha: float = 1.0
) -> list[Artist]:
    """Draw the arm from above, and a dashed line from its hand to the selected object."""
    shoulder, elbow, hand = (place[:2] for place in arm_points(state.pose, state.arm))
    xs, ys = zip(shoulder, elbow, hand, strict=True)
    look: Any = {"color": ARM, "alpha": alpha}
    artists: list[Artist] = []
    artists += axes.plot(xs, ys, lw=4.5, solid_capstyle="round", zorder=5, **look)
    artists += axes.plot(xs[:2], ys[:2], "o", ms=6, mfc="white", mew=1.6, zorder=5, **look)
    artists += axes.plot(xs[2:], ys[2:], "o", ms=7, zorder=5, **look)
    target = place_of(state.selected, settings)
    if target:
        artists += axes.plot([hand[0], target[0]], [hand[1], target[1]], zorder=1.5, **RAY, **look)
    return artists


def draw_collisions(axes: Axes, collisions: Sequence[TripMark]) -> list[tuple[float, Artist]]:
    """Draw a cross where the base hit something, each with its time."""
    return [(hit.t, axes.plot(hit.x, hit.y, zorder=6, **CROSS)[0]) for hit in collisions]
