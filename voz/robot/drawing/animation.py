"""A trip as it happened, as GIF or MP4. Needs matplotlib, and MP4 needs the program ffmpeg."""

from __future__ import annotations

import subprocess
import tempfile
from collections.abc import Iterator
from contextlib import suppress
from itertools import chain
from math import ceil
from pathlib import Path
from typing import IO, TypeAlias, cast

import numpy as np
import numpy.typing as npt
from PIL import Image

from voz.files import atomic_write
from voz.robot.drawing.scene import Scene
from voz.robot.simulator import Trip

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


def save(trip: Trip, path: Path) -> None:
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


def _interval(trip: Trip, most: int) -> float:
    """Return the time between frames, s, in whole hundredths as a GIF stores it."""
    return max(FRAME_INTERVAL, ceil((trip.states[-1].t + FINAL_PAUSE) / most * 100) / 100)


def _save_gif(trip: Trip, path: Path) -> None:
    interval = _interval(trip, MAX_GIF_FRAMES)
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
    interval = _interval(trip, MAX_MP4_FRAMES)
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
