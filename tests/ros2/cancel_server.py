"""What an action server does when it is asked to cancel, by the real rclpy: prints the request.

There are no wheels of an action's type; the service that cancels goals is the same for all.
"""

from __future__ import annotations

import json
import sys
from typing import Any

import rclpy
from action_msgs.srv import CancelGoal
from rclpy.executors import ExternalShutdownException

service = json.loads(sys.argv[1])["service"]


def cancel(request: Any, response: Any) -> Any:
    asked = request.goal_info
    told = {
        "goal": [int(byte) for byte in asked.goal_id.uuid],
        "stamp": [asked.stamp.sec, asked.stamp.nanosec],
    }
    print(json.dumps(told), flush=True)
    return response


rclpy.init()
node = rclpy.create_node("goals")
node.create_service(CancelGoal, service, cancel)
print(json.dumps({"ready": True}), flush=True)
try:
    rclpy.spin(node)
except (KeyboardInterrupt, ExternalShutdownException):
    rclpy.try_shutdown()
