"""Cancels the goals by which others, as Nav2, drive the robot: zero velocity does not end them."""

from __future__ import annotations

import time
from collections.abc import Sequence
from typing import Any
from uuid import UUID

from cyclonedds.pub import DataWriter

from voz.ros2.message_types import CancelAllGoals, CycloneCancelAllGoals
from voz.ros2.node import LAST_WORD, Ros2Node, answered, write
from voz.ros2.subscribers import Endpoints

AT_A_TIME = 32
"""So many of those that came are looked at in a beat: the thread that does sends velocities too."""

CYCLONE = bytes([1, 16])
"""How the numbers of Cyclone's readers begin: with the vendor's."""


class Goals:
    """The goals of some actions; who serves them may come and go."""

    def __init__(self, node: Ros2Node, actions: Sequence[str]) -> None:
        """Prepare to look who serves the actions.

        Args:
            node: asks them.
            actions: their names, in the order in which they are cancelled.
        """
        self._node = node
        self._arriving = Endpoints(node)
        self._services = [f"{action}/_action/cancel_goal" for action in actions]
        self._requests: dict[str, DataWriter[Any]] = {}

    def look(self) -> None:
        """Get ready to ask those who came to serve, each in its way; of several, who came last.

        A request for Cyclone is too long for Fast DDS, which would ask for it again for ever, so
        nobody may get one that is not for him.
        """
        arrived = {one.topic_name: one.key for one in self._arriving.new(AT_A_TIME)}
        for service in self._services:
            server = arrived.get(self._node.request_topic(service))
            if server is None:
                continue
            kind, before = _layout(server), self._requests.get(service)
            if before is None or before.topic.data_type is not kind:
                self._requests.pop(service, None)
                self._requests[service] = self._node.requests(service, kind)

    def cancel(self) -> None:
        """Ask for the end of all goals, and wait for no answer; raises RobotError as `write`."""
        for service in self._services:
            if service in self._requests:
                requests = self._requests[service]
                write(requests, requests.topic.data_type())

    def wait(self) -> None:
        """Wait until what was asked has arrived, for a moment."""
        until = time.monotonic() + LAST_WORD
        for requests in self._requests.values():
            answered(requests, max(0.0, until - time.monotonic()))


def _layout(key: UUID) -> type[CancelAllGoals | CycloneCancelAllGoals]:
    """How a server reads a request, by its number."""
    return CycloneCancelAllGoals if key.bytes.startswith(CYCLONE) else CancelAllGoals
