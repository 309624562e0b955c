"""The example that hears what voz understood, run by the real rclpy."""

from __future__ import annotations

import subprocess

import pytest
from programs import wait_until
from recordings import ROOT
from ros2.conftest import RCLPY

from voz.events import Utterance
from voz.ros2 import Ros2Robot
from voz.settings import Ros2


@pytest.mark.slow
@pytest.mark.usefixtures("domain")
def test_it_prints_what_was_obeyed() -> None:
    robot = Ros2Robot(Ros2(wait=0))
    robot.open()
    command = [str(RCLPY), str(ROOT / "examples" / "ros2_listener.py")]
    with subprocess.Popen(command, stdout=subprocess.PIPE, text=True) as listener:
        try:
            wait_until(lambda: robot._output.get_matched_subscriptions())
            robot.receive(Utterance(0, "go back", 0.9, True, 0, 1, "text", obeyed=True))
            assert listener.stdout
            assert listener.stdout.readline() == "go back\n"
        finally:
            listener.kill()
            robot.close()
