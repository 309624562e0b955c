"""The sketch of `examples/arduino`, compiled for this computer, at the end of voz's serial port."""

from __future__ import annotations

import os
import subprocess
import sys
import tty
from pathlib import Path

import pytest
from documents import recipe
from recordings import ROOT

HERE = ROOT / "tests" / "arduino"

STILL = (0, 0)


@pytest.fixture(scope="module")
def sketch(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The program of the sketch."""
    program = tmp_path_factory.mktemp("arduino") / "sketch"
    folders = ["-I", str(HERE), "-I", str(ROOT / "examples" / "arduino")]
    source = str(HERE / "main.cpp")
    subprocess.run(["g++", "-Wall", "-Werror", *folders, source, "-o", program], check=True)
    return program


def pins(sketch: Path, *lines: str) -> list[tuple[int, ...]]:
    """How speed of the wheels, servo and light stand after each line."""
    done = subprocess.run(
        [sketch], input="".join(f"{line}\n" for line in lines), capture_output=True, text=True
    )
    return [tuple(map(int, line.split())) for line in done.stdout.splitlines()]


def wheels(sketch: Path, *lines: str) -> list[tuple[int, ...]]:
    return [each[:2] for each in pins(sketch, *lines)]


def test_the_wheels_turn_as_a_velocity_says(sketch: Path) -> None:
    ahead, left, right, back, fast = wheels(
        sketch, "v 0.10 0.00", "v 0.10 0.50", "v 0.00 -0.50", "v -0.20 0.00", "v 9.00 0.00"
    )
    assert ahead == (51, 51)
    assert 0 < left[0] < 51 < left[1]
    assert right[0] == -right[1] > 0
    assert back == (-102, -102)
    assert fast == (255, 255)


def test_the_wheels_stand_still_when_no_line_comes_for_half_a_second(sketch: Path) -> None:
    found = wheels(sketch, "v 0.10 0.00", *"+++++++", "v 0.10 0.00")
    assert found[1:6] == [(51, 51)] * 5
    assert found[6:8] == [STILL] * 2
    assert found[8] == (51, 51)


@pytest.mark.parametrize(
    "broken", ["v 0.10", "v", "v 0.1x 0", "0.10 0.00", "v 0.10 0.00" * 9, "\0"]
)
def test_a_line_that_is_broken_moves_nothing_and_counts_for_none(broken: str, sketch: Path) -> None:
    assert wheels(sketch, broken, "v 0.10 0.00", *[broken] * 7)[::8] == [STILL, STILL]


def test_a_servo_and_a_light_do_what_is_said(sketch: Path) -> None:
    found = pins(sketch, "c wave", "c light on", "c wave", "c light off", "c unknown")
    assert [each[2:] for each in found] == [(0, 0), (0, 1), (90, 1), (90, 0), (90, 0)]
    assert pins(sketch, "v 0 0")[0][2:] == (90, 0)


@pytest.mark.realtime
def test_the_recipe_drives_it_by_what_voz_writes(sketch: Path, tmp_path: Path) -> None:
    environment = os.environ | {
        "PATH": f"{Path(sys.executable).parent}:{os.environ['PATH']}",
        "PYTHONPATH": str(ROOT),
    }
    (typed,) = recipe("An Arduino with motors, a servo and a light").blocks("sh")
    subprocess.run(["sh", "-ec", typed], cwd=tmp_path, env=environment, check=True)
    folder = tmp_path / "cart"
    firmware, cable = os.openpty()
    tty.setraw(cable)
    settings = (folder / "voz.toml").read_text().replace("/dev/ttyUSB0", os.ttyname(cable))
    (folder / "voz.toml").write_text(settings)
    said = ["start speech", "go forward", *"---", "turn left", *"---", "wave", "light on", "stop"]
    run = [sys.executable, "-m", "voz", "run", "--no-sound", "--text", "-"]
    lines = "\n".join(said)
    subprocess.run(run, cwd=folder, env=environment, input=lines, text=True, check=True)
    found = pins(sketch, *os.read(firmware, 8000).decode().splitlines())
    os.close(firmware)
    os.close(cable)
    assert (51, 51, 90, 0) in found
    assert any(0 < left < 51 < right for left, right, *_ in found)
    assert found[-1] == (0, 0, 0, 1)  # it has waved, shines, and stands
