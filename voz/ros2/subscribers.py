"""Who listens to a topic and who else writes it, with the names of their nodes."""

from __future__ import annotations

from collections.abc import Set
from typing import Any

from cyclonedds.builtin import (
    BuiltinDataReader,
    BuiltinTopicDcpsParticipant,
    BuiltinTopicDcpsPublication,
    BuiltinTopicDcpsSubscription,
)
from cyclonedds.core import InstanceState, ReadCondition, SampleState, ViewState
from cyclonedds.pub import DataWriter
from cyclonedds.qos import Policy

from voz.ros2.node import Ros2Node, take

MAX_ENDPOINTS = 10_000
"""Readers of a domain that are examined; a large robot has some hundred."""

MAX_NEW_ENDPOINTS = 32
"""New endpoints that are examined in a beat, by the thread that also sends velocities."""

NODE_SERVICE = "/describe_parametersRequest"
"""Each ROS 2 node reads this topic below its own name, which is nowhere else."""

ONLY_ZERO = b"voz=only_zero;"
"""Userdata of a writer that moves nothing: voz's watchdog, or the doctor's look at who listens."""


class Endpoints:
    """All readers in the domain, this process's own included; or all writers, or programs."""

    def __init__(self, node: Ros2Node, kind: Any = BuiltinTopicDcpsSubscription) -> None:
        self._arrivals = BuiltinDataReader(node.participant, kind)
        any_sample = ViewState.Any | SampleState.Any
        self._there = ReadCondition(self._arrivals, any_sample | InstanceState.Alive)
        gone = InstanceState.NotAliveDisposed | InstanceState.NotAliveNoWriters
        self._gone = ReadCondition(self._arrivals, any_sample | gone)
        self._known: dict[int, Any] = {}

    def all(self) -> dict[int, Any]:
        """Return those that exist now, by the numbers that DDS gives them."""
        self.new(MAX_ENDPOINTS)
        return self._known

    def new(self, most: int) -> dict[int, Any]:
        """Return at most `most` (0.1 ms each) that are new since the last call."""
        for one in take(self._arrivals, most, self._gone):
            self._known.pop(one.sample_info.instance_handle, None)
        arrived = take(self._arrivals, most, self._there)
        new = {one.sample_info.instance_handle: one for one in arrived}
        self._known |= new
        return new

    def still(self, handles: Set[int]) -> Set[int]:
        """Return those of some that have not gone, as far as `new` or `all` saw."""
        return handles & self._known.keys()


class ProgramNames:
    """Names programs in the domain, for people."""

    def __init__(self, node: Ros2Node) -> None:
        self._readers = Endpoints(node)
        self._programs = Endpoints(node, BuiltinTopicDcpsParticipant)

    def of(self, endpoint: Any) -> str:
        """Return the node, or nodes of one process, that an endpoint belongs to."""
        nodes = sorted(
            reader.topic_name.removeprefix("rq").removesuffix(NODE_SERVICE)
            for reader in self._readers.all().values()
            if reader.participant_key == endpoint.participant_key
            and reader.topic_name.endswith(NODE_SERVICE)
        )
        return " or ".join(nodes) or self._process(endpoint.participant_key)

    def _process(self, key: Any) -> str:
        """Name a program without a node, as another voz is; Cyclone tells of its process."""
        for program in self._programs.all().values():
            if program.key == key:
                said = {p.key: p.value for p in program.qos if isinstance(p, Policy.Property)}
                if number := said.get("__Pid"):
                    name, host = said.get("__ProcessName"), said.get("__Hostname")
                    return f"process {number} ({name}) on {host}"
        return "a program without a node's name"


class MatchedReaders:
    """The readers that a writer's messages go to."""

    def __init__(self, node: Ros2Node, writer: DataWriter[Any]) -> None:
        self._writer = writer
        self._readers = Endpoints(node)
        self._names = ProgramNames(node)

    def handles(self) -> set[int]:
        """Return a number for each subscriber, as `Endpoints` has it, and not with a sign."""
        return {handle % 2**64 for handle in self._writer.get_matched_subscriptions()}

    def name(self, handle: int) -> str:
        """Return the node, or nodes of one process, of a subscriber."""
        listener = self._readers.all().get(handle)
        return self._names.of(listener) if listener else "somebody"

    def obstacle(self, topic: str) -> str | None:
        """Return why a reader of the topic is not matched; `topic` is its name for people."""
        ours = self._writer.topic
        for reader in self._readers.all().values():
            if reader.topic_name != ours.name:
                continue
            if reader.type_name == ours.typename:
                return f"a listener to {topic} asks for a quality of service that is not offered"
            wanted, sent = _as_in_ros(reader.type_name), _as_in_ros(ours.typename)
            return f"a listener to {topic} wants {wanted}, not {sent}: see `stamped` in voz.toml"
        return None


class OtherWriters:
    """Other programs whose messages go to the same readers, but for those that only send zero."""

    def __init__(self, node: Ros2Node, writer: DataWriter[Any]) -> None:
        self._topic = writer.topic.name, writer.topic.typename
        self._own = node.participant.guid
        self._writers = Endpoints(node, BuiltinTopicDcpsPublication)
        self._names = ProgramNames(node)
        self._found: dict[int, str] = {}

    def names(self, most: int = MAX_ENDPOINTS) -> Set[str]:
        """Return who they are now; at most `most` writers that are new are examined."""
        for handle, one in self._writers.new(most).items():
            if self._counts(one):
                self._found[handle] = self._names.of(one)
        still = self._writers.still(self._found.keys())
        self._found = {handle: name for handle, name in self._found.items() if handle in still}
        return frozenset(self._found.values())

    def _counts(self, writer: Any) -> bool:
        if (writer.topic_name, writer.type_name) != self._topic:
            return False
        said = writer.qos[Policy.Userdata]
        return writer.participant_key != self._own and not (said and ONLY_ZERO in said.data)


def _as_in_ros(type_name: str) -> str:
    return type_name.replace("::dds_::", "/").replace("::", "/").rstrip("_")


ACKNOWLEDGE_TIMEOUT = 0.5
"""A subscriber that acknowledges nothing for this time, s, is gone.

DDS itself lists a killed program as connected for another 10 to 20 s.
"""


class SubscriberLiveness:
    """Finds subscribers that acknowledge nothing: a connection is not enough. Reads no clock."""

    def __init__(self) -> None:
        self._asked: float | None = None
        self._silent: Set[int] = frozenset()

    def update(self, now: float, listeners: Set[int], answered: bool) -> None:
        """Note whether all connected listeners have acknowledged the last message."""
        if answered:
            self._asked, self._silent = None, frozenset()
        elif self._asked is None:
            self._asked = now
        elif now - self._asked >= ACKNOWLEDGE_TIMEOUT and not self._silent:
            # It is unknown which of them is silent; later ones are not.
            self._silent = frozenset(listeners)

    def alive(self, listeners: Set[int]) -> Set[int]:
        """Return those of the connected listeners that may be alive."""
        return listeners - self._silent
