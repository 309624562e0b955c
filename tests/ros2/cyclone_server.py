"""What the service that cancels goals is asked for, as ROS 2 on Cyclone reads it: prints requests.

rmw_cyclonedds puts its `cdds_request_header_t` before each request.
"""

# No `from __future__ import annotations`: cyclonedds looks the written types up in this module.

import json
import sys
import time
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Annotated

from cyclonedds.idl import IdlStruct
from cyclonedds.idl.annotations import final
from cyclonedds.idl.types import array, int64, uint8, uint64
from cyclonedds.sub import DataReader
from cyclonedds.topic import Topic

from voz.ros2.message_types import TYPE_HASHES, CancelAllGoals, Time
from voz.ros2.node import Ros2Node
from voz.settings import Ros2


@dataclass
@final
class Uuid(IdlStruct, typename="unique_identifier_msgs::msg::dds_::UUID_"):
    uuid: Annotated[Sequence[int], array(uint8, 16)]


@dataclass
@final
class GoalInfo(IdlStruct, typename="action_msgs::msg::dds_::GoalInfo_"):
    goal_id: Uuid
    stamp: Time


@dataclass
@final
class Request(IdlStruct, typename="action_msgs::srv::dds_::CancelGoal_Request_"):
    guid: uint64
    seq: int64
    goal_info: GoalInfo


TYPE_HASHES[Request] = TYPE_HASHES[CancelAllGoals]
node = Ros2Node(Ros2())
topic = Topic(node.participant, f"rq/{json.loads(sys.argv[1])['service']}Request", Request)
reader = DataReader(node.participant, topic, node.qos(Request))
print(json.dumps({"ready": True}), flush=True)
while True:
    for asked in reader.take(10):
        if isinstance(asked, Request):
            goal, stamp = asked.goal_info.goal_id.uuid, asked.goal_info.stamp
            told = {"goal": list(goal), "stamp": [stamp.sec, stamp.nanosec]}
            print(json.dumps(told), flush=True)
    time.sleep(0.02)
