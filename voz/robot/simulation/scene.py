"""The picture of a trip at any time, and all of them as GIF or MP4. Needs matplotlib."""

from __future__ import annotations

import subprocess
import tempfile
from bisect import bisect_right
from collections.abc import Iterator
from contextlib import suppress
from itertools import chain
from math import ceil
from pathlib import Path
from typing import IO, Any, TypeAlias, cast

import numpy as np
import numpy.typing as npt
from matplotlib import rc_context
from matplotlib.artist import Artist
from matplotlib.axes import Axes
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from PIL import Image

from voz.files import atomic_write
from voz.robot.simulation import shapes
from voz.robot.simulation.labels import (
    distance,
    pointings,
    seconds_between,
    time_marks,
    write_along,
)
from voz.robot.simulation.simulator import Trip
from voz.robot.simulation.world import WorldState
from voz.settings import Simulator

MAX_ROOM_WIDTH, MAX_ROOM_HEIGHT = 7.8, 6.4
"""Of the room in the picture, inches; the smaller scale counts."""

LEFT, RIGHT, BOTTOM, TOP = 0.5, 0.2, 0.65, 0.4
"""Margins around the room, inches."""

PICTURE_DPI = 150
"""Pixels in an inch of a PNG."""

MIN_PICTURE_WIDTH = 7.5
"""Of the picture, inches: the legend needs it."""

PLOT_STYLE: Any = {  # its type would be a literal of all names that matplotlib knows
    "font.size": 9,
    "svg.hashsalt": "voz",  # the same trip gives the same file
    "text.parse_math": False,  # a command with $ in it is no formula
}


class Scene:
    """A figure of the room, and the parts that change with time."""

    def __init__(self, trip: Trip, dpi: int) -> None:
        """Draw what does not change; `dpi` is the number of pixels in an inch."""
        self._trip = trip
        self._times = [state.t for state in trip.states]
        self._way = np.array([state.pose[:2] for state in trip.states])
        self._dots = time_marks(trip.states)
        self._pointings = pointings(trip)
        self._moment: list[Artist] = []
        with rc_context(PLOT_STYLE):
            self.figure, self._axes = _empty(trip.settings, dpi)
            self.canvas: Any = FigureCanvasAgg(self.figure)  # its methods have no types
            things = shapes.draw_room(self._axes, trip.settings)
            self._collisions = shapes.draw_collisions(self._axes, trip.collisions)
            self._labels = write_along(self._axes, self.canvas, trip, self._dots, things)
            self._title = self._axes.set_title("", loc="left", fontsize=11)
            self._write_legend()

    @property
    def title(self) -> str:
        """The text above the room."""
        return self._title.get_text()

    def show(self, t: float) -> list[Artist]:
        """Show the state at a time, s; return all that changes with time, in drawing order."""
        count = max(1, bisect_right(self._times, t))
        for artist in self._moment:
            artist.remove()
        for label in self._labels:
            label.show(t)
        for since, cross in self._collisions:
            cross.set_visible(since <= t)
        self._title.set_text(self._summary(self._trip.states[count - 1], t))
        with rc_context(PLOT_STYLE):
            self._moment = self._draw(count, t)
        lasting = [artist for label in self._labels for artist in label.artists]
        lasting += [self._title, *(cross for _, cross in self._collisions)]
        return sorted(self._moment + lasting, key=Artist.get_zorder)

    def _draw(self, count: int, t: float) -> list[Artist]:
        axes, settings, states = self._axes, self._trip.settings, self._trip.states
        state = states[count - 1]
        dots = np.array([(dot.x, dot.y) for dot in self._dots if dot.t <= t]).reshape(-1, 2)
        artists = [shapes.draw_outline(axes, states[0].pose, settings)]
        artists += axes.plot(*self._way[:count].T, color=shapes.WAY, lw=2.2, zorder=4.5)
        artists += axes.plot(*dots.T, ls="", zorder=4.5, **shapes.DOT)
        for earlier in self._pointings:
            if earlier.t < state.t:
                artists.append(shapes.draw_outline(axes, earlier.pose, settings))
                artists += shapes.draw_arm(axes, earlier, settings, alpha=0.4)
        artists += shapes.draw_robot(axes, state.pose, settings)
        return artists + shapes.draw_arm(axes, state, settings)

    def _summary(self, state: WorldState, t: float) -> str:
        end = self._times[-1]
        if t < end:
            motion = f"{state.linear:.2f} m/s    {state.angular:.2f} rad/s"
            return f"{t:.1f} s    {motion}".replace("-", "\u2212")
        said, shown = len(self._trip.said), sum(label.commands for label in self._labels)
        commands = f"{said} command{'' if said == 1 else 's'}"
        if shown < said:
            commands += f", {shown} of them shown"
        return f"{distance(self._trip.states):.2f} m in {end:.0f} s, driven by {commands}"

    def _write_legend(self) -> None:
        def sign(**look: Any) -> Line2D:
            return Line2D([], [], **look)

        entries = {"start": sign(ls="", marker="o", ms=11, mfc="none", mec=shapes.FAINT, mew=1.2)}
        if self._trip.said:
            entries["a command heard"] = sign(ls="", marker="o", ms=7.5, color=shapes.SAID)
        if len(self._dots) > 1:
            every = f"a mark every {seconds_between(self._dots):g} s"
            entries[every] = sign(color=shapes.WAY, lw=2.2, **shapes.DOT)
        if self._pointings:
            entries["the arm points"] = sign(color=shapes.ARM, **shapes.RAY)
        if self._trip.collisions:
            entries["a collision"] = sign(**shapes.CROSS)
        self.figure.legend(
            list(entries.values()), list(entries), loc="lower center", ncols=len(entries),
            frameon=False, columnspacing=2, handletextpad=0.7,
        )  # fmt: skip


def _empty(settings: Simulator, dpi: int) -> tuple[Figure, Axes]:
    scale = min(MAX_ROOM_WIDTH / settings.room[0], MAX_ROOM_HEIGHT / settings.room[1])
    width, height = settings.room[0] * scale, settings.room[1] * scale
    total = max(LEFT + width + RIGHT, MIN_PICTURE_WIDTH), BOTTOM + height + TOP
    figure = Figure(figsize=total, dpi=dpi)
    place = (LEFT / total[0], BOTTOM / total[1], width / total[0], height / total[1])
    return figure, figure.add_axes(place)


def write_picture(trip: Trip, path: Path) -> None:
    """Write the picture of a whole trip as PNG or SVG, by the ending; raises OSError."""
    scene = Scene(trip, PICTURE_DPI)
    scene.show(trip.states[-1].t)
    kind = path.suffix[1:].lower()
    # Without the time of writing, so that the same trip gives the same file.
    about = {"Title": scene.title, ("Date" if kind == "svg" else "Software"): None}
    with rc_context(PLOT_STYLE), atomic_write(path, "wb") as file:
        scene.figure.savefig(file, format=kind, metadata=about)


Frame: TypeAlias = npt.NDArray[np.uint8]
"""Red, green, blue and opacity of each pixel."""

ANIMATION_DPI = 90
"""Pixels in an inch: text is legible, and 20 s are not much more than a megabyte."""

FINAL_PAUSE = 2.0
"""How long the end is shown, s."""

FRAME_INTERVAL = 0.1
"""Time between frames, s: that between velocities."""

MAX_GIF_FRAMES, MAX_MP4_FRAMES = 1200, 12_000
"""A longer trip has fewer frames a second; Pillow keeps those of a GIF in memory."""


def write_animation(trip: Trip, path: Path) -> None:
    """Write a trip as GIF or MP4, by the ending; raises OSError."""
    if path.suffix.lower() == ".gif":
        _save_gif(trip, path)
    else:
        _save_mp4(trip, path)


def frames(trip: Trip, interval: float) -> Iterator[Frame]:
    """Draw a trip at times `interval` s apart, and its end for a while."""
    scene = Scene(trip, ANIMATION_DPI)
    for artist in scene.show(0.0):
        artist.set_animated(True)
    scene.canvas.draw()
    background = scene.canvas.copy_from_bbox(scene.figure.bbox)
    end = trip.states[-1].t
    for number in range(ceil((end + FINAL_PAUSE) / interval)):
        scene.canvas.restore_region(background)
        for artist in scene.show(min(number * interval, end)):
            artist.draw(scene.canvas.get_renderer())
        yield np.array(scene.canvas.buffer_rgba())


def frame_interval(trip: Trip, most: int) -> float:
    """Return the time between frames, s, in whole hundredths as a GIF stores it."""
    return max(FRAME_INTERVAL, ceil((trip.states[-1].t + FINAL_PAUSE) / most * 100) / 100)


def _save_gif(trip: Trip, path: Path) -> None:
    interval = frame_interval(trip, MAX_GIF_FRAMES)
    whole = Scene(trip, ANIMATION_DPI)
    whole.show(trip.states[-1].t)
    whole.canvas.draw()
    # All frames have the palette of the last one, which shows everything.
    palette = _image(np.array(whole.canvas.buffer_rgba())).quantize()
    images = (
        _image(frame).quantize(palette=palette, dither=Image.Dither.NONE)
        for frame in frames(trip, interval)
    )
    first = next(images)
    duration = round(interval * 1000)
    with atomic_write(path, "wb") as file:
        first.save(file, "GIF", save_all=True, append_images=images, duration=duration, loop=0)


def _image(frame: Frame) -> Image.Image:
    return Image.fromarray(frame).convert("RGB")


def _save_mp4(trip: Trip, path: Path) -> None:
    interval = frame_interval(trip, MAX_MP4_FRAMES)
    pictures = frames(trip, interval)
    first = next(pictures)
    command = [
        *("ffmpeg", "-loglevel", "error", "-y", "-f", "rawvideo", "-pix_fmt", "rgba"),
        *("-s", f"{first.shape[1]}x{first.shape[0]}", "-r", f"{1 / interval:g}", "-i", "-"),
        # Every player understands an even number of pixels with colors at half of them.
        *("-vf", "pad=ceil(iw/2)*2:ceil(ih/2)*2:color=white", "-pix_fmt", "yuv420p"),
        *("-movflags", "+faststart", "-f", "mp4"),
    ]
    with atomic_write(path, "wb") as film, tempfile.TemporaryFile() as said:
        number = film.fileno()  # it has no name yet
        command.append(f"file:/dev/fd/{number}")
        with (
            subprocess.Popen(
                command, stdin=subprocess.PIPE, stderr=said, pass_fds=[number]
            ) as process,
            suppress(BrokenPipeError),  # ffmpeg has ended, and said why
            cast(IO[bytes], process.stdin) as pipe,
        ):
            for picture in chain([first], pictures):
                pipe.write(picture.tobytes())
        if process.returncode:
            said.seek(0)
            lines = said.read().decode(errors="replace").splitlines()
            raise OSError(f"ffmpeg: {lines[0] if lines else 'failed'}")
