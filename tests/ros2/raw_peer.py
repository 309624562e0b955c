"""Another program by Cyclone DDS: the bytes of each line of its input go out on `odom`."""

# No `from __future__ import annotations`: cyclonedds looks the written types up in this module.

import json
import sys
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Annotated

from cyclonedds.idl import IdlStruct
from cyclonedds.idl.annotations import final
from cyclonedds.idl.types import sequence, uint8

from voz.ros2.message_types import TYPE_HASHES, Odometry
from voz.ros2.node import Ros2Node
from voz.settings import Ros2


@dataclass
@final
class Raw(IdlStruct, typename="nav_msgs::msg::dds_::Odometry_"):
    """What follows the first field, the seconds: in its place is the number of bytes."""

    data: Annotated[Sequence[uint8], sequence(uint8)]


TYPE_HASHES[Raw] = TYPE_HASHES[Odometry]
odom = Ros2Node(Ros2()).writer("odom", Raw)
print(json.dumps({"ready": True}), flush=True)
for line in sys.stdin:
    odom.write(Raw(list(bytes.fromhex(line))))
