"""Who listens to a topic: by name, so that a person can tell whether it is the right one."""

from __future__ import annotations

from typing import Any

from cyclonedds.builtin import BuiltinDataReader, BuiltinTopicDcpsSubscription
from cyclonedds.core import InstanceState, ReadCondition, SampleState, ViewState
from cyclonedds.pub import DataWriter

from voz.ros2.node import Ros2Node

MOST = 10_000
"""So many readers in the domain are looked at; a large robot has some hundred."""

SERVICE = "/describe_parametersRequest"
"""Each ordinary node reads this below its own name; its names are nowhere else in all of ROS 2."""


class Endpoints:
    """All readers in the domain, those that this process makes too; or all writers."""

    def __init__(self, node: Ros2Node, kind: Any = BuiltinTopicDcpsSubscription) -> None:
        self._endpoints = BuiltinDataReader(node.participant, kind)
        any_sample = ViewState.Any | SampleState.Any
        self._there = ReadCondition(self._endpoints, any_sample | InstanceState.Alive)
        gone = InstanceState.NotAliveDisposed | InstanceState.NotAliveNoWriters
        self._gone = ReadCondition(self._endpoints, any_sample | gone)

    def all(self) -> list[Any]:
        """Those that are there now."""
        self._endpoints.take(MOST, self._gone)  # or they would be kept for ever
        return list(self._endpoints.read(MOST, self._there))

    def new(self, most: int) -> list[Any]:
        """Those that came since the last call, each told once; `all` does not know them then.

        Args:
            most: so many at a time: each takes 0.1 ms, and there may be hundreds.
        """
        self._endpoints.take(most, self._gone)
        return list(self._endpoints.take(most, self._there))

    def of(self, topic: str) -> list[Any]:
        """Those of a topic, by the name that DDS has for it."""
        return [one for one in self.all() if one.topic_name == topic]


class Listeners:
    """The readers that a writer's messages go to."""

    def __init__(self, readers: Endpoints, writer: DataWriter[Any]) -> None:
        self._writer = writer
        self._readers = readers

    def handles(self) -> set[int]:
        """One number for each listener."""
        return set(self._writer.get_matched_subscriptions())

    def name(self, handle: int) -> str:
        """The node, or nodes of one process, to which a listener belongs."""
        listener = self._writer.get_matched_subscription_data(handle)
        if listener is None:
            return "somebody"
        nodes = sorted(
            reader.topic_name.removeprefix("rq").removesuffix(SERVICE)
            for reader in self._readers.all()
            if reader.participant_key == listener.participant_key
            and reader.topic_name.endswith(SERVICE)
        )
        return " or ".join(nodes) or "a program without a node's name"

    def obstacle(self, topic: str) -> str | None:
        """Why somebody who wants to listen cannot; for when nobody does.

        Args:
            topic: its name for people.
        """
        ours = self._writer.topic
        for reader in self._readers.of(ours.name):
            if reader.type_name == ours.typename:
                return f"a listener to {topic} asks for a quality of service that is not offered"
            wanted, sent = _as_in_ros(reader.type_name), _as_in_ros(ours.typename)
            return f"a listener to {topic} wants {wanted}, not {sent}: see `stamped` in voz.toml"
        return None


def _as_in_ros(type_name: str) -> str:
    return type_name.replace("::dds_::", "/").replace("::", "/").rstrip("_")
