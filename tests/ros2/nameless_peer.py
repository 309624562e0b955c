"""A program whose topic, or the type of it, has a name that is no UTF-8, as other DDS may send.

Its one argument is JSON: `what` is "topic" or "type". Cyclone makes no such name, so it is
overwritten in the memory of this process before Cyclone sends it.
"""

# No `from __future__ import annotations`: cyclonedds looks the written types up in this module.

import ctypes
import json
import re
import sys
from dataclasses import dataclass
from pathlib import Path

from cyclonedds.idl import IdlStruct
from cyclonedds.idl.annotations import final
from cyclonedds.idl.types import uint8
from cyclonedds.pub import DataWriter
from cyclonedds.sub import DataReader
from cyclonedds.topic import Topic

from voz.ros2.node import Ros2Node
from voz.settings import Ros2


@dataclass
@final
class Odd(IdlStruct, typename="odd::type::name::QQQ"):
    data: uint8


def overwrite(name: bytes) -> None:
    """Put three bytes that are no UTF-8 at the end of a text, wherever it is in memory."""
    writable = re.compile(r"([0-9a-f]+)-([0-9a-f]+) rw.. \S+ \S+ 0 *(\[heap\])?$", re.MULTILINE)
    maps = Path("/proc/self/maps").read_text()
    places = [(int(m[1], 16), int(m[2], 16)) for m in writable.finditer(maps)]
    for begin, end in places:
        memory = ctypes.string_at(begin, end - begin)
        for found in re.finditer(re.escape(name) + b"\0", memory):
            ctypes.memmove(begin + found.end() - 4, b"\xff\xfe\xff", 3)


what = json.loads(sys.argv[1])["what"]
node = Ros2Node(Ros2())
topic = Topic(node.participant, "rt/odd/topic/QQQ", Odd)
overwrite({"topic": b"rt/odd/topic/QQQ", "type": b"odd::type::name::QQQ"}[what])
reader, writer = DataReader(node.participant, topic), DataWriter(node.participant, topic)
print(json.dumps({"ready": True}), flush=True)
sys.stdin.read()
