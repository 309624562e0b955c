from __future__ import annotations

import json
import subprocess
from pathlib import Path

import numpy as np
import pytest
from full_disk import full_disk
from msgspec.structs import replace
from PIL import Image

from voz.errors import ConfigError
from voz.robot.drawing import check_animation, save_animation
from voz.robot.drawing.animation import FINAL_PAUSE, MAX_GIF_FRAMES, _interval, frames
from voz.robot.simulator import Trip


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
    assert _interval(short, MAX_GIF_FRAMES) == 0.1
    interval = _interval(hour, MAX_GIF_FRAMES)
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
