"""The launch file for `ros2 launch`, which itself no package registry has: what it starts."""

from __future__ import annotations

import re
import runpy
import subprocess

from calls import VOZ
from recordings import ROOT

launch_file = runpy.run_path(str(ROOT / "ros" / "launch" / "voz.launch.py"))


def test_what_is_not_given_is_left_out_and_no_settings_are_those_of_any_folder() -> None:
    arguments = dict.fromkeys(["voz", *launch_file["OPTIONS"], *launch_file["SWITCHES"]], "")
    arguments |= {"voz": "/opt/voz", "device": "USB mic", "listening": "true", "no-sound": "false"}
    assert launch_file["command"](arguments) == [
        "/opt/voz", "run", "--robot", "ros2", "--device=USB mic", "--config=/dev/null",
        "--listening",
    ]  # fmt: skip


def test_settings_that_are_given_are_read() -> None:
    arguments = {"voz": "voz", "config": "mine.toml"}
    assert launch_file["command"](arguments)[-1] == "--config=mine.toml"


def test_voz_run_has_every_option_that_the_launch_file_offers() -> None:
    done = subprocess.run([*VOZ, "run", "--help"], capture_output=True, text=True, check=True)
    there = set(re.findall(r"--([a-z-]+)", done.stdout))
    assert {*launch_file["OPTIONS"], *launch_file["SWITCHES"]} <= there
