"""An ordinary ROS 2 program, run by the Python that has rclpy: prints what it hears as JSON lines.

Its one argument is JSON: `stamped`, `namespace`, `deadline` and `lease` (s), `manual`. Each line of
its standard input is published on `recognizer/output`. It knows nothing of voz.
"""

from __future__ import annotations

import json
import sys
import threading
import time
from typing import Any

import numpy
import rclpy
from diagnostic_msgs.msg import DiagnosticArray
from geometry_msgs.msg import Twist, TwistStamped
from nav_msgs.msg import Odometry
from rclpy.duration import Duration
from rclpy.event_handler import SubscriptionEventCallbacks
from rclpy.executors import ExternalShutdownException
from rclpy.qos import LivelinessPolicy, QoSProfile
from std_msgs.msg import Bool, Float64, Int16, Int32, String

lock = threading.Lock()


def tell(**what: Any) -> None:
    with lock:
        print(json.dumps(what | {"at": time.time()}), flush=True)


def plain(value: Any) -> Any:
    if hasattr(value, "get_fields_and_field_types"):
        return {name: plain(getattr(value, name)) for name in value.get_fields_and_field_types()}
    if isinstance(value, list | tuple | numpy.ndarray):
        return [plain(one) for one in value]
    return ord(value) if isinstance(value, bytes) else value


def qos_of(wanted: dict[str, Any]) -> QoSProfile:
    qos = QoSProfile(depth=100)
    if "deadline" in wanted:
        qos.deadline = Duration(seconds=wanted["deadline"])
    if "lease" in wanted:
        qos.liveliness_lease_duration = Duration(seconds=wanted["lease"])
        manual = wanted.get("manual", False)
        policy = LivelinessPolicy.MANUAL_BY_TOPIC if manual else LivelinessPolicy.AUTOMATIC
        qos.liveliness = policy
    return qos


def callbacks() -> SubscriptionEventCallbacks:
    return SubscriptionEventCallbacks(
        deadline=lambda event: tell(event="deadline", count=event.total_count),
        liveliness=lambda event: tell(event="liveliness", alive=event.alive_count),
        incompatible_qos=lambda event: tell(event="incompatible", policy=str(event)),
        use_default_callbacks=False,
    )


def main() -> None:
    wanted = json.loads(sys.argv[1])
    rclpy.init()
    node = rclpy.create_node("base", namespace=wanted.get("namespace"))
    twist = TwistStamped if wanted.get("stamped") else Twist
    topics = {
        "cmd_vel": twist,
        "selected_object": Int16,
        "recognizer/output": String,
        "odom": Odometry,
        "/diagnostics": DiagnosticArray,
    }
    if wanted.get("values"):
        topics |= {"lamp": Bool, "count": Int32, "way": Float64, "bring": String}
    for topic, message in topics.items():
        moves = topic == "cmd_vel"
        node.create_subscription(
            message,
            topic,
            lambda heard, topic=topic: tell(topic=topic, message=plain(heard)),
            qos_of(wanted) if moves else 10,
            event_callbacks=callbacks() if moves else None,
        )
    publisher = node.create_publisher(String, "recognizer/output", 10)

    def publish() -> None:
        for line in sys.stdin:
            publisher.publish(String(data=line.rstrip("\n")))

    told: dict[str, Any] = {}

    def look_around() -> None:
        graph = {
            topic: {
                "types": types,
                "writers": [
                    [info.topic_type, str(info.topic_type_hash)]
                    for info in node.get_publishers_info_by_topic(topic)
                    if info.node_name != node.get_name()
                ],
                "own": [
                    [info.topic_type, str(info.topic_type_hash)]
                    for info in node.get_subscriptions_info_by_topic(topic)
                    if info.node_name == node.get_name()
                ],
            }
            for topic, types in node.get_topic_names_and_types()
        }
        if graph != told.get("graph"):
            told["graph"] = graph
            tell(graph=graph)

    node.create_timer(0.2, look_around)
    threading.Thread(target=publish, daemon=True).start()
    tell(ready=True)
    try:
        rclpy.spin(node)
    except (KeyboardInterrupt, ExternalShutdownException):
        rclpy.try_shutdown()


main()
