"""Cancels the goals by which others, as Nav2, drive the robot: zero velocity does not end them."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any
from uuid import UUID

from cyclonedds.pub import DataWriter

from voz.ros2.listeners import Endpoints
from voz.ros2.messages import CancelAllGoals, CycloneCancelAllGoals
from voz.ros2.node import LAST_WORD, Node, answered, write

CYCLONE = bytes([1, 16])
"""How the numbers of Cyclone's readers begin: with the vendor's."""


class Goals:
    """The goals of some actions; who serves them may come and go."""

    def __init__(self, node: Node, readers: Endpoints, actions: Sequence[str]) -> None:
        """Prepare to look who serves the actions.

        Args:
            node: asks them.
            readers: of the domain.
            actions: their names, in the order in which they are cancelled.
        """
        self._node = node
        self._readers = readers
        self._services = [f"{action}/_action/cancel_goal" for action in actions]
        self._requests: dict[str, DataWriter[Any]] = {}

    def look(self) -> None:
        """Get ready to ask those who serve now, each in its way.

        A request for Cyclone is too long for Fast DDS, which would ask for it again for ever, so
        nobody may get one that is not for him.
        """
        if not self._services:
            return
        there = {reader.topic_name: reader.key for reader in self._readers.all()}
        for service in self._services:
            server = there.get(self._node.request_topic(service))
            kind = _layout(server) if server else None
            if service in self._requests and self._requests[service].topic.data_type is not kind:
                del self._requests[service]
            if kind and service not in self._requests:
                self._requests[service] = self._node.requests(service, kind)

    def cancel(self) -> None:
        """Ask for the end of all goals, and wait for no answer; raises RobotError as `write`."""
        for service in self._services:
            if service in self._requests:
                requests = self._requests[service]
                write(requests, requests.topic.data_type())

    def wait(self) -> None:
        """Wait until what was asked has arrived, for a moment."""
        for requests in self._requests.values():
            answered(requests, LAST_WORD)


def _layout(key: UUID) -> type[CancelAllGoals | CycloneCancelAllGoals]:
    """How a server reads a request, by its number."""
    return CycloneCancelAllGoals if key.bytes.startswith(CYCLONE) else CancelAllGoals
