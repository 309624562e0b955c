"""Cancels the goals of other programs, such as Nav2; zero velocity does not end them."""

from __future__ import annotations

import time
from collections.abc import Sequence
from typing import Any
from uuid import UUID

from cyclonedds.pub import DataWriter

from voz.ros2.message_types import CancelAllGoals, CycloneCancelAllGoals
from voz.ros2.node import FINAL_ACK_TIMEOUT, Ros2Node, all_acknowledged, write
from voz.ros2.subscribers import MAX_NEW_ENDPOINTS, Endpoints

CYCLONE_VENDOR = bytes([1, 16])
"""The vendor number with which Cyclone's endpoint numbers begin."""


class GoalCanceller:
    """Cancels all goals of some actions, whose servers may come and go."""

    def __init__(self, node: Ros2Node, actions: Sequence[str]) -> None:
        """Prepare to cancel the goals of actions, in this order."""
        self._node = node
        self._arriving = Endpoints(node)
        self._services = [f"{action}/_action/cancel_goal" for action in actions]
        self._requests: dict[str, DataWriter[Any]] = {}

    def look(self) -> None:
        """Make a writer of requests for each new server; of several, for the last.

        Fast DDS would wait forever for a request in Cyclone's longer format.
        """
        new = self._arriving.new(MAX_NEW_ENDPOINTS).values()
        arrived = {one.topic_name: one.key for one in new}
        for service in self._services:
            server = arrived.get(self._node.request_topic(service))
            if server is None:
                continue
            kind, before = _layout(server), self._requests.get(service)
            if before is None or before.topic.data_type is not kind:
                self._requests.pop(service, None)
                self._requests[service] = self._node.requests(service, kind)

    def cancel(self) -> None:
        """Request the end of all goals without waiting; raises RobotError as `write`."""
        for service in self._services:
            if service in self._requests:
                requests = self._requests[service]
                write(requests, requests.topic.data_type())

    def wait(self) -> None:
        """Wait a short time until the requests have arrived."""
        until = time.monotonic() + FINAL_ACK_TIMEOUT
        for requests in self._requests.values():
            all_acknowledged(requests, max(0.0, until - time.monotonic()))


def _layout(key: UUID) -> type[CancelAllGoals | CycloneCancelAllGoals]:
    return CycloneCancelAllGoals if key.bytes.startswith(CYCLONE_VENDOR) else CancelAllGoals
