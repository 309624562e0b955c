"""Another program by Cyclone DDS alone: listens to /cmd_vel, and publishes what it is told to.

Each line of its standard input goes out on `recognizer/output` in Latin 1, which may be no text.
"""

# No `from __future__ import annotations`: cyclonedds looks the written types up in this module.

import json
import sys
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Annotated

from cyclonedds.idl import IdlStruct
from cyclonedds.idl.annotations import final
from cyclonedds.idl.types import sequence, uint8

from voz.ros2.message_types import TYPE_HASHES, String, TwistMessage
from voz.ros2.node import Ros2Node
from voz.settings import Ros2


@dataclass
@final
class Bytes(IdlStruct, typename="std_msgs::msg::dds_::String_"):
    """The bytes of a text and the zero after it: on the wire they look like a text."""

    data: Annotated[Sequence[uint8], sequence(uint8)]


TYPE_HASHES[Bytes] = TYPE_HASHES[String]
node = Ros2Node(Ros2())
base = node.reader("cmd_vel", TwistMessage)
output = node.writer("recognizer/output", Bytes)
print(json.dumps({"ready": True}), flush=True)
for line in sys.stdin:
    output.write(Bytes([*line.rstrip("\n").encode("latin-1"), 0]))
