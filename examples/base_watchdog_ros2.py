#!/usr/bin/env python3
"""Stops a base of ROS 2 that drives on when no velocity comes any more.

It stands between voz and the base. Let it run on the computer that the base is connected to, so
that no network is between them, and name the topic that the base listens to:

    ./base_watchdog_ros2.py --ros-args -r base_cmd_vel:=/base/cmd_vel

It passes Twist, or with `-p stamped:=true` behind `--ros-args` TwistStamped.

It is no safety function: if this program, its computer or the cable to the base fails, nothing
stops the base but a switch that cuts its power.
"""

import signal
import sys
import time

import rclpy
from geometry_msgs.msg import Twist, TwistStamped
from rclpy.clock import Clock, ClockType
from rclpy.node import Node
from rclpy.signals import SignalHandlerOptions

PATIENCE = 0.5
"""Without a velocity for so long the base gets zero, s; voz sends one every 0.1 s."""

PAUSE = 0.05
"""Between two looks at the clock, s."""


class Watchdog(Node):
    """Passes each velocity on, and remembers when the last one came."""

    def __init__(self) -> None:
        super().__init__("base_watchdog")
        self.came = time.monotonic()
        self.stamped = self.declare_parameter("stamped", False).value
        kind = TwistStamped if self.stamped else Twist
        self.base = self.create_publisher(kind, "base_cmd_vel", 1)
        self.create_subscription(kind, "cmd_vel", self.pass_on, 1)
        # Not the clock of ROS: a simulation may stop that.
        self.create_timer(PAUSE, self.watch, clock=Clock(clock_type=ClockType.STEADY_TIME))

    def pass_on(self, velocity: Twist | TwistStamped) -> None:
        """Give the base a velocity that came."""
        self.came = time.monotonic()
        self.base.publish(velocity)

    def watch(self) -> None:
        """Give the base zero for as long as none comes."""
        if time.monotonic() - self.came > PATIENCE:
            self.publish_zero()

    def stop(self) -> None:
        """Give the base zero, and time for it to arrive."""
        self.publish_zero()
        time.sleep(PAUSE)

    def publish_zero(self) -> None:
        """Give the base zero."""
        zero = TwistStamped() if self.stamped else Twist()
        if self.stamped:
            zero.header.stamp = self.get_clock().now().to_msg()
        self.base.publish(zero)


if __name__ == "__main__":
    # Not rclpy's own way to end: after that nothing can be published.
    rclpy.init(signal_handler_options=SignalHandlerOptions.NO)
    signal.signal(signal.SIGINT, lambda *_: sys.exit())
    signal.signal(signal.SIGTERM, lambda *_: sys.exit())
    watchdog = Watchdog()
    try:
        rclpy.spin(watchdog)
    finally:
        watchdog.stop()
