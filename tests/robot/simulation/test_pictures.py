from __future__ import annotations

import json
import re
import struct
import subprocess
import sys
import xml.etree.ElementTree as ET
from itertools import combinations
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from full_disk import full_disk
from matplotlib.lines import Line2D
from matplotlib.patches import Circle
from matplotlib.text import Text
from msgspec.structs import replace
from PIL import Image

from voz.errors import ConfigError
from voz.robot.simulation.pictures import (
    check_animation,
    check_picture,
    save_animation,
    save_picture,
)
from voz.robot.simulation.scene import FINAL_PAUSE, MAX_GIF_FRAMES, Scene, frame_interval, frames
from voz.robot.simulation.simulator import Trip
from voz.robot.simulation.world import arm_points
from voz.settings import Simulator


def texts(scene: Scene) -> list[str]:
    """What is written, one string for each label."""
    found = [text for text in scene.figure.findobj(Text) if text.get_visible()]
    return [text.get_text() for text in found if text.get_text()]


def shown(trip: Trip, t: float = 1e9) -> Scene:
    scene = Scene(trip, 100)
    scene.show(t)
    return scene


def test_png_and_svg_by_the_ending_and_the_same_each_time(tour: Trip, tmp_path: Path) -> None:
    for ending in (".png", ".svg", ".PNG"):
        first, again = tmp_path / f"first{ending}", tmp_path / f"again{ending}"
        save_picture(tour, first)
        save_picture(tour, again)
        assert first.read_bytes() == again.read_bytes()
    width, height = struct.unpack(">II", (tmp_path / "first.png").read_bytes()[16:24])
    assert width > 1000
    assert height > 700
    svg = ET.parse(tmp_path / "first.svg").getroot()
    assert svg.tag == "{http://www.w3.org/2000/svg}svg"


def test_all_commands_are_written_with_their_times(tour: Trip) -> None:
    written = "\n".join(texts(shown(tour)))
    for said in tour.said:
        assert re.search(rf"\b{said.t:.1f} s  {said.text}$", written, re.MULTILINE)
    assert "driven by 9 commands" in written
    for name in ("beer", "cocacola", "table", "start", "a collision", "the arm points"):
        assert name in written


def test_no_text_covers_another(tour: Trip) -> None:
    scene = shown(tour)
    scene.canvas.draw()
    found = [text for text in scene.figure.findobj(Text) if text.get_visible() and text.get_text()]
    boxes = [(text.get_text(), text.get_window_extent()) for text in found]
    assert len(boxes) > 15
    for (one, box), (another, other) in combinations(boxes, 2):
        assert not box.overlaps(other), (one, another)


def test_the_robot_its_arm_and_its_target_are_where_they_are(tour: Trip) -> None:
    state = next(s for s in reversed(tour.states) if s.selected == 2)
    scene = shown(tour, state.t)
    circles = [c for c in scene.figure.findobj(Circle) if c.get_radius() == 0.17]
    assert state.pose[:2] in [c.center for c in circles]
    lines = [list(zip(*line.get_data(), strict=True)) for line in scene.figure.findobj(Line2D)]
    shoulder, elbow, hand = (place[:2] for place in arm_points(state.pose, state.arm))
    assert [shoulder, elbow, hand] in lines
    assert [hand, Simulator().cocacola] in lines


def test_a_moment_shows_what_was_until_then(tour: Trip) -> None:
    early, late = shown(tour, 3.0), shown(tour)
    assert "go forward" in "\n".join(texts(early))
    assert "turn left" not in "\n".join(texts(early))
    assert any(text.startswith("3.0 s    0.10 m/s    0.00 rad/s") for text in texts(early))
    crosses = [
        [line.get_visible() for line in scene.figure.findobj(Line2D) if line.get_marker() == "x"]
        for scene in (early, late)
    ]
    assert crosses[0].count(True) + 1 == crosses[1].count(True)  # the legend's apart


def test_more_commands_than_there_is_room_for_are_counted(driven: Any) -> None:
    here = driven(["stop"] * 30)
    assert "and 22 more" in "\n".join(texts(shown(here)))
    tight = Simulator(
        room=(1.2, 0.4), table=(1.0, 0.2, 0.2, 0.2), beer=(1.1, 0.3), cocacola=(1.1, 0.3),
        start=(0.2, 0.2, 0.0), radius=0.05,
    )  # fmt: skip
    steps = [[way, *["-"] * 8, "stop", "-"] for way in ("go forward", "go back") for _ in range(7)]
    many = driven([line for step in steps for line in step] * 4, tight)
    assert re.search(r"113 commands, \d+ of them shown", "\n".join(texts(shown(many))))


@pytest.mark.parametrize(
    "settings",
    [
        Simulator(),
        Simulator(room=(90, 3), table=(80, 1, 1, 1), beer=(80, 1), cocacola=(81, 2)),
        Simulator(room=(1, 90), table=(0, 80, 1, 1), beer=(0, 80), cocacola=(1, 81)),
    ],
)
def test_every_room_and_nothing_said_can_be_drawn(
    settings: Simulator, driven: Any, tmp_path: Path
) -> None:
    save_picture(driven(["-"], settings), tmp_path / "empty.png")
    save_picture(driven(["go forward", *["-"] * 20, "point beer"], settings), tmp_path / "way.svg")
    assert (tmp_path / "empty.png").stat().st_size > 5000
    ET.parse(tmp_path / "way.svg")


def test_a_name_that_cannot_be_is_one_line_before_the_work(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    with pytest.raises(
        ConfigError, match=r"a\.jpg: not a file name .*; end it with \.png or \.svg$"
    ):
        check_picture(tmp_path / "a.jpg")
    (tmp_path / "folder.png").mkdir()
    for path in (tmp_path / "none" / "a.png", tmp_path / "folder.png"):
        with pytest.raises(ConfigError, match=r"^.*a?\.png: cannot be written there; [^\n]+$"):
            check_picture(path)
    monkeypatch.setitem(sys.modules, "matplotlib", None)
    with pytest.raises(ConfigError, match=r"matplotlib is not installed; run `.* -m pip install"):
        check_picture(tmp_path / "a.png")


def test_what_fails_only_when_it_is_written_is_one_line_too(short: Trip, tmp_path: Path) -> None:
    full = tmp_path / "full.png"
    full.symlink_to("/dev/full")
    with pytest.raises(ConfigError, match=r"full\.png: cannot be written \(No space left"):
        save_picture(short, full)
    with pytest.raises(ConfigError, match=r"\.svg: cannot be written \(File name too long\)$"):
        save_picture(short, tmp_path / ("a" * 300 + ".svg"))


def test_a_picture_that_cannot_be_finished_leaves_the_old_one(short: Trip, tmp_path: Path) -> None:
    path = tmp_path / "way.png"
    path.write_bytes(b"old")
    with full_disk(5000), pytest.raises(ConfigError, match=r"cannot be written \(File too large"):
        save_picture(short, path)
    assert path.read_bytes() == b"old"
    assert list(tmp_path.iterdir()) == [path]


@pytest.mark.slow
def test_a_gif_is_as_long_as_the_trip_and_ends_with_its_end(short: Trip, tmp_path: Path) -> None:
    path = tmp_path / "trip.gif"
    save_animation(short, path)
    with Image.open(path) as image:
        assert image.format == "GIF"
        assert image.info["loop"] == 0
        total, pictures = 0, []
        for number in range(image.n_frames):
            image.seek(number)
            total += image.info["duration"]
            pictures.append(np.asarray(image.convert("RGB"), int))
    assert total / 1000 == pytest.approx(short.states[-1].t + FINAL_PAUSE, abs=0.11)
    assert len(pictures) > 15
    assert (pictures[0] != pictures[-1]).any()


@pytest.mark.slow
def test_an_mp4_is_as_long_as_the_trip(short: Trip, tmp_path: Path) -> None:
    path = tmp_path / "trip.mp4"
    save_animation(short, path)
    command = ["ffprobe", "-v", "error", "-show_streams", "-of", "json", path]
    (video,) = json.loads(subprocess.check_output(command))["streams"]
    assert video["pix_fmt"] == "yuv420p"
    assert video["width"] % 2 == video["height"] % 2 == 0
    assert float(video["duration"]) == pytest.approx(short.states[-1].t + FINAL_PAUSE, abs=0.11)


@pytest.mark.slow
def test_frames_move_while_the_robot_does_and_stand_when_it_stands(short: Trip) -> None:
    pictures = list(frames(short, 0.5))
    below_title = [picture[60:] for picture in pictures]
    assert (below_title[2] != below_title[3]).any()
    assert (pictures[-1] == pictures[-2]).all()


def test_a_long_trip_has_fewer_frames_and_the_same_speed(short: Trip) -> None:
    hour = replace(short, states=(*short.states, replace(short.states[-1], t=3600.0)))
    assert frame_interval(short, MAX_GIF_FRAMES) == 0.1
    interval = frame_interval(hour, MAX_GIF_FRAMES)
    assert (3600 + FINAL_PAUSE) / interval <= MAX_GIF_FRAMES
    assert round(interval * 100) == pytest.approx(interval * 100)


def test_a_name_that_cannot_be_is_one_line(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    with pytest.raises(ConfigError, match=r"a\.avi: not a file name for .* with \.gif or \.mp4$"):
        check_animation(tmp_path / "a.avi")
    check_animation(tmp_path / "a.mp4")
    monkeypatch.setenv("PATH", str(tmp_path))
    with pytest.raises(ConfigError, match=r"a\.mp4: needs ffmpeg; run `sudo apt-get install"):
        check_animation(tmp_path / "a.mp4")
    check_animation(tmp_path / "a.gif")


@pytest.mark.slow
@pytest.mark.parametrize("ending", [".mp4", ".gif"])
def test_what_fails_only_when_it_is_written_is_one_line(
    ending: str, short: Trip, tmp_path: Path
) -> None:
    full = tmp_path / f"full{ending}"
    full.symlink_to("/dev/full")
    with pytest.raises(ConfigError, match=r"full\.\w+: cannot be written \([^\n]*No space left"):
        save_animation(short, full)


@pytest.mark.slow
@pytest.mark.parametrize("ending", [".mp4", ".gif"])
def test_an_animation_that_cannot_be_finished_leaves_the_old_one(
    ending: str, short: Trip, tmp_path: Path
) -> None:
    path = tmp_path / f"way{ending}"
    path.write_bytes(b"old")
    with full_disk(5000), pytest.raises(ConfigError, match=r"way\.\w+: cannot be written \([^\n]*"):
        save_animation(short, path)
    assert path.read_bytes() == b"old"
    assert list(tmp_path.iterdir()) == [path]
