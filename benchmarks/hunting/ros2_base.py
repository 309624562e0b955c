"""A base on ROS 2: tells an observer each velocity on /cmd_vel, and when it arrived."""

from __future__ import annotations

import os
import time

from voz.ros2.message_types import TwistMessage
from voz.ros2.node import Ros2Node
from voz.settings import Ros2

observer = os.open(os.environ["HUNT_OBSERVER"], os.O_WRONLY)
reader = Ros2Node(Ros2()).reader("cmd_vel", TwistMessage)
while True:
    for twist in reader.take(100):
        if isinstance(twist, TwistMessage):  # else it tells that a writer is gone
            told = f"ros2 {time.monotonic()} {twist.linear.x} {twist.angular.z}\n"
            os.write(observer, told.encode())
    time.sleep(0.01)
