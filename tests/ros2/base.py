"""A base on ROS 2: it turns as it is told, and tells its odometry 20 times a second.

`patience` is how long it goes on without a velocity, s. It prints each velocity.
"""

import json
import sys
import time

from voz.ros2.message_types import (
    HeaderMessage,
    Odometry,
    Point,
    Pose,
    PoseWithCovariance,
    Quaternion,
    Time,
    TwistMessage,
    TwistWithCovariance,
    velocity,
)
from voz.ros2.node import Ros2Node
from voz.settings import Ros2

patience = json.loads(sys.argv[1])["patience"]
node = Ros2Node(Ros2())
wheels, odom = node.reader("cmd_vel", TwistMessage), node.writer("odom", Odometry)
here = PoseWithCovariance(Pose(Point(), Quaternion()))
asked, came = velocity(0, 0), time.monotonic()
print(json.dumps({"ready": True}), flush=True)
while True:
    for twist in wheels.take(100):
        if isinstance(twist, TwistMessage):
            asked, came = twist, time.monotonic()
            print(json.dumps({"linear": twist.linear.x, "angular": twist.angular.z}), flush=True)
    speed = asked if time.monotonic() - came < patience else velocity(0, 0)
    odom.write(
        Odometry(HeaderMessage(Time(0, 0), "odom"), "base_link", here, TwistWithCovariance(speed))
    )
    time.sleep(0.05)
