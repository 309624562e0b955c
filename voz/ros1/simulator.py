"""The node `simulator`: a robot that is not there, for RViz and for trying out."""

from __future__ import annotations

import math
import queue
from queue import SimpleQueue
from typing import Any, NoReturn

from voz.events import SelectedObject, Twist
from voz.robot.simulator import SimulatedRobot
from voz.ros1.node import Node, load_rospy
from voz.ros1.parameters import read_settings
from voz.ros1.program import clock_from_now, run_node
from voz.simulation.world import State

PERIOD = 0.05
"""How often `odom` and `tf` go out, s."""

ODOM, BASE = "odom", "base_link"
"""The frames; the first has its origin in a corner of the room."""


def simulate(node: Node) -> None:
    """Follow `cmd_vel` and `selected_object`, and tell where the robot is, until the end."""
    from geometry_msgs.msg import Twist as Velocity
    from nav_msgs.msg import Odometry
    from rospy import Publisher, Subscriber
    from std_msgs.msg import Int16
    from tf2_msgs.msg import TFMessage

    settings, clock = read_settings(), clock_from_now()
    rospy = load_rospy()
    robot = SimulatedRobot(settings.simulator, lambda warning: rospy.logwarn(warning.text))
    inbox: SimpleQueue[Twist | SelectedObject] = SimpleQueue()

    def velocity(message: Any) -> None:
        inbox.put(Twist(clock(), message.linear.x, message.angular.z))

    Subscriber(settings.ros1.cmd_vel, Velocity, velocity)
    Subscriber(
        settings.ros1.selected_object,
        Int16,
        lambda message: inbox.put(SelectedObject(clock(), message.data)),
    )
    odom = Publisher("odom", Odometry, queue_size=10)
    tf = Publisher("/tf", TFMessage, queue_size=10)
    due = 0.0
    while not node.over:
        due += PERIOD
        while (left := due - clock()) > 0:
            try:
                robot.receive(inbox.get(timeout=left))
            except queue.Empty:
                break
        state = robot.state_at(clock())
        now = rospy.Time.now()
        odom.publish(_odometry(state, now))
        tf.publish(TFMessage([_transform(state, now)]))


def _odometry(state: State, now: Any) -> Any:
    from nav_msgs.msg import Odometry

    message = Odometry()
    message.header.stamp, message.header.frame_id = now, ODOM
    message.child_frame_id = BASE
    position, orientation = message.pose.pose.position, message.pose.pose.orientation
    position.x, position.y = state.pose.x, state.pose.y
    orientation.z, orientation.w = _half_turn(state)
    message.twist.twist.linear.x = state.linear
    message.twist.twist.angular.z = state.angular
    return message


def _transform(state: State, now: Any) -> Any:
    from geometry_msgs.msg import TransformStamped

    message = TransformStamped()
    message.header.stamp, message.header.frame_id = now, ODOM
    message.child_frame_id = BASE
    place, rotation = message.transform.translation, message.transform.rotation
    place.x, place.y = state.pose.x, state.pose.y
    rotation.z, rotation.w = _half_turn(state)
    return message


def _half_turn(state: State) -> tuple[float, float]:
    """The z and w of the heading as a quaternion."""
    return math.sin(state.pose.heading / 2), math.cos(state.pose.heading / 2)


def main() -> NoReturn:
    """Run the node."""
    run_node("simulator", simulate)


if __name__ == "__main__":
    main()
