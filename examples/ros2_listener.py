"""Hear on ROS 2 what voz understood (voz run --robot ros2): python3 examples/ros2_listener.py."""

import signal

import rclpy
from rclpy.node import Node
from std_msgs.msg import String

rclpy.init()
for number in (signal.SIGINT, signal.SIGPIPE):  # end without a word by Ctrl-C, or as in `| head`
    signal.signal(number, signal.SIG_DFL)
node = Node("listener")
node.create_subscription(String, "recognizer/output", lambda said: print(said.data, flush=True), 10)
rclpy.spin(node)
