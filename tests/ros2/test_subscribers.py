"""The example that hears what voz understood, run by the real rclpy."""

from __future__ import annotations

import signal
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
def test_it_prints_what_was_obeyed_and_is_ended_by_ctrl_c() -> None:
    robot = Ros2Robot(Ros2(wait=0))
    robot.open()
    command = [str(RCLPY), str(ROOT / "examples" / "ros2_listener.py")]
    pipe = subprocess.PIPE
    with subprocess.Popen(command, stdout=pipe, stderr=pipe, text=True) as listener:
        try:
            output = next(w for w in robot.writers if w.topic.name == "rt/recognizer/output")
            wait_until(output.get_matched_subscriptions)
            robot.receive(Utterance(0, "go back", 0.9, True, 0, 1, "text", obeyed=True))
            assert listener.stdout
            assert listener.stdout.readline() == "go back\n"
            listener.send_signal(signal.SIGINT)
            assert listener.wait(60) == -signal.SIGINT
            assert listener.stderr
            assert "Traceback" not in listener.stderr.read()
        finally:
            listener.kill()
            robot.close()
