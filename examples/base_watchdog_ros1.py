#!/usr/bin/python3
"""Stops a base of ROS 1 that drives on when no velocity comes any more.

It stands between voz and the base. Let it run on the computer that the base is connected to, so
that no network is between them, and name the topic that the base listens to:

    ./base_watchdog_ros1.py base_cmd_vel:=/mobile_base/commands/velocity

It is no safety function: if this program, its computer or the cable to the base fails, nothing
stops the base but a switch that cuts its power.
"""

import time
from contextlib import suppress

import rospy
from geometry_msgs.msg import Twist

PATIENCE = 0.5
"""Without a velocity for so long the base gets zero, s; voz sends one every 0.1 s."""

PAUSE = 0.05
"""Between two looks at the clock, s."""


class Watchdog:
    """Passes each velocity on, and remembers when the last one came."""

    def __init__(self) -> None:
        # The clock of the computer, not that of ROS: a simulation may stop that.
        self.came = time.monotonic()
        self.base = rospy.Publisher("base_cmd_vel", Twist, queue_size=1)
        self.velocities = rospy.Subscriber("cmd_vel", Twist, self.pass_on, queue_size=1)

    def pass_on(self, velocity: Twist) -> None:
        """Give the base a velocity that came."""
        self.came = time.monotonic()
        self.base.publish(velocity)

    def watch(self) -> None:
        """Give the base zero for as long as none comes."""
        while not rospy.is_shutdown():
            if time.monotonic() - self.came > PATIENCE:
                with suppress(rospy.ROSException):  # it ends at this very moment
                    self.base.publish(Twist())
            time.sleep(PAUSE)

    def stop(self) -> None:
        """Give the base zero, and time for it to arrive."""
        self.velocities.unregister()
        self.base.publish(Twist())
        time.sleep(PAUSE)


if __name__ == "__main__":
    rospy.init_node("base_watchdog")
    watchdog = Watchdog()
    rospy.on_shutdown(watchdog.stop)
    watchdog.watch()
