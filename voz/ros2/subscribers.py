"""The subscribers of a topic, with the names of their nodes."""

from __future__ import annotations

from typing import Any

from cyclonedds.builtin import BuiltinDataReader, BuiltinTopicDcpsSubscription
from cyclonedds.core import InstanceState, ReadCondition, SampleState, ViewState
from cyclonedds.pub import DataWriter

from voz.ros2.node import Ros2Node

MAX_ENDPOINTS = 10_000
"""Readers of a domain that are examined; a large robot has some hundred."""

NODE_SERVICE = "/describe_parametersRequest"
"""Each ROS 2 node reads this topic below its own name, which is nowhere else."""


class Endpoints:
    """All readers in the domain, this process's own included; or all writers."""

    def __init__(self, node: Ros2Node, kind: Any = BuiltinTopicDcpsSubscription) -> None:
        self._endpoints = BuiltinDataReader(node.participant, kind)
        any_sample = ViewState.Any | SampleState.Any
        self._there = ReadCondition(self._endpoints, any_sample | InstanceState.Alive)
        gone = InstanceState.NotAliveDisposed | InstanceState.NotAliveNoWriters
        self._gone = ReadCondition(self._endpoints, any_sample | gone)

    def all(self) -> list[Any]:
        """Return those that exist now."""
        self._endpoints.take(MAX_ENDPOINTS, self._gone)  # else they would be kept forever
        return list(self._endpoints.read(MAX_ENDPOINTS, self._there))

    def new(self, most: int) -> list[Any]:
        """Return at most `most` (0.1 ms each) that are new since the last call, and forget them."""
        self._endpoints.take(most, self._gone)
        return list(self._endpoints.take(most, self._there))

    def of(self, topic: str) -> list[Any]:
        """Return those of a topic, by its DDS name."""
        return [one for one in self.all() if one.topic_name == topic]


class MatchedReaders:
    """The readers that a writer's messages go to."""

    def __init__(self, readers: Endpoints, writer: DataWriter[Any]) -> None:
        self._writer = writer
        self._readers = readers

    def handles(self) -> set[int]:
        """Return a number for each subscriber."""
        return set(self._writer.get_matched_subscriptions())

    def name(self, handle: int) -> str:
        """Return the node, or nodes of one process, of a subscriber."""
        listener = self._writer.get_matched_subscription_data(handle)
        if listener is None:
            return "somebody"
        nodes = sorted(
            reader.topic_name.removeprefix("rq").removesuffix(NODE_SERVICE)
            for reader in self._readers.all()
            if reader.participant_key == listener.participant_key
            and reader.topic_name.endswith(NODE_SERVICE)
        )
        return " or ".join(nodes) or "a program without a node's name"

    def obstacle(self, topic: str) -> str | None:
        """Return why a reader of the topic is not matched; `topic` is its name for people."""
        ours = self._writer.topic
        for reader in self._readers.of(ours.name):
            if reader.type_name == ours.typename:
                return f"a listener to {topic} asks for a quality of service that is not offered"
            wanted, sent = _as_in_ros(reader.type_name), _as_in_ros(ours.typename)
            return f"a listener to {topic} wants {wanted}, not {sent}: see `stamped` in voz.toml"
        return None


def _as_in_ros(type_name: str) -> str:
    return type_name.replace("::dds_::", "/").replace("::", "/").rstrip("_")
