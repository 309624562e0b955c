"""The node `simulator`: a robot that is not there, for RViz and for trying out."""

from __future__ import annotations

import queue
import time
from queue import SimpleQueue
from typing import Any, NoReturn

from voz.events import SelectedObject, Twist
from voz.robot.simulation.simulator import SimulatedRobot
from voz.ros1.node import Ros1Node, load_rospy, read_settings, run_node, subscribe
from voz.ros1.robot import Ros1OdometryPublisher

ODOMETRY_PERIOD = 0.05
"""How often `odom` and `tf` go out, s."""


def simulate(node: Ros1Node) -> None:
    """Follow `cmd_vel` and `selected_object`, and publish the odometry, until the end."""
    from geometry_msgs.msg import Twist as Velocity
    from std_msgs.msg import Int16

    settings, begun = read_settings(), time.monotonic()
    rospy = load_rospy()
    robot = SimulatedRobot(settings.simulator, lambda warning: rospy.logwarn(warning.text))
    inbox: SimpleQueue[Twist | SelectedObject] = SimpleQueue()

    def clock() -> float:
        return time.monotonic() - begun

    def velocity(message: Any) -> None:
        inbox.put(Twist(clock(), message.linear.x, message.angular.z))

    subscribe(settings.ros1.cmd_vel, Velocity, velocity)
    subscribe(
        settings.ros1.selected_object,
        Int16,
        lambda message: inbox.put(SelectedObject(clock(), message.data)),
    )
    odometry = Ros1OdometryPublisher()
    due = 0.0
    while not node.over:
        due = max(due + ODOMETRY_PERIOD, clock())  # missed periods are left out
        while (left := due - clock()) > 0:
            try:
                robot.receive(inbox.get(timeout=left))
            except queue.Empty:
                break
        odometry.publish(robot.state_at(clock()))


def main() -> NoReturn:
    """Run the node."""
    run_node("simulator", simulate)


if __name__ == "__main__":
    main()
