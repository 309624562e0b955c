"""Drives forward on ROS 2 until a signal ends it, as `voz run` would; its argument is not used."""

from __future__ import annotations

import json
import signal
import sys
import time
from contextlib import closing

from voz.config import Ros2, Safety
from voz.control.safety import zero_at_the_end
from voz.drive import Drive
from voz.events import Utterance
from voz.robot.ros2 import Ros2Robot

signal.signal(signal.SIGTERM, lambda number, frame: sys.exit(0))
robot = Ros2Robot(Ros2(wait=30))
robot.open()
drive = Drive([robot.receive], Safety(), listening=True)
begun = time.monotonic()


def clock() -> float:
    return time.monotonic() - begun


with closing(robot), zero_at_the_end(lambda: drive.zero(clock())):
    print(json.dumps({"lost": robot.lost()}), flush=True)
    drive.hear(Utterance(clock(), "go forward", 1.0, True, 0.0, 0.0, "text"))
    while True:
        drive.send(clock())
        time.sleep(0.1)
