"""A participant of a ROS 2 domain, by Cyclone DDS, without ROS."""

from __future__ import annotations

import os
from collections.abc import Iterator
from typing import Any, TypeVar
from weakref import WeakValueDictionary

from cyclonedds.core import DDSException, ReadCondition
from cyclonedds.domain import Domain, DomainParticipant
from cyclonedds.idl import IdlStruct
from cyclonedds.internal import InvalidSample
from cyclonedds.pub import DataWriter
from cyclonedds.qos import BasePolicy, Policy, Qos
from cyclonedds.sub import DataReader
from cyclonedds.topic import Topic

from voz.errors import RobotError
from voz.ros2.discovery import check_cyclone, cyclone_settings, domain_number
from voz.ros2.message_types import TYPE_HASHES
from voz.settings import Ros2

Message = TypeVar("Message", bound=IdlStruct)

HISTORY_DEPTH = 10
"""Messages kept for a reader that does not keep up; ROS 2's own default."""

MAX_BLOCKING_TIME = 100_000_000
"""How long a full queue may block a message, ns: one beat."""

RELIABLE = Policy.Reliability.Reliable(max_blocking_time=MAX_BLOCKING_TIME)

FINAL_ACK_TIMEOUT = 0.3
"""How long an end waits for the last velocity to be acknowledged, s."""

_domains: WeakValueDictionary[int, Domain] = WeakValueDictionary()
"""A process can be in a domain only once."""


class _Participant(DomainParticipant):
    """Keeps a reference to its domain, which ends with the last one."""

    def __init__(self, number: int) -> None:
        self._domain = _domains.get(number) or _domain(number)
        _domains[number] = self._domain
        super().__init__(number)


def _domain(number: int) -> Domain:
    configuration = cyclone_settings(os.environ)
    check_cyclone(number, configuration, os.environ)
    return Domain(number, configuration)


class Ros2Node:
    """Makes writers and readers of topics; lives until nobody uses them."""

    def __init__(self, settings: Ros2) -> None:
        """Join the domain of the settings, or of the environment.

        Raises:
            ConfigError: an environment variable is invalid.
            RobotError: it cannot be joined.
        """
        self._namespace = settings.namespace
        number = domain_number(settings, os.environ)
        try:
            self.participant = _Participant(number)
        except DDSException as error:
            raise RobotError(
                f"ROS 2 domain {number} cannot be joined ({_short(error)}): "
                "look at CYCLONEDDS_URI, ROS_STATIC_PEERS and the network"
            ) from error

    def name(self, topic: str) -> str:
        """Return the full name of a topic, as `ros2 topic list` shows it."""
        return topic if topic.startswith("/") else "/".join(["", *self._prefix(), topic])

    def writer(
        self, topic: str, message: type[Message], *policies: BasePolicy, mark: bytes = b""
    ) -> DataWriter[Message]:
        """Return a writer that ROS 2 nodes can read; `policies` are offered besides reliability.

        `mark` is userdata, as NAME=VALUE and a semicolon.
        """
        qos = self.qos(message, *policies, mark=mark)
        return DataWriter(self.participant, self.topic(topic, message), qos)

    def reader(
        self, topic: str, message: type[Message], *policies: BasePolicy
    ) -> DataReader[Message]:
        """Return a reader of what ROS 2 nodes write; the arguments are those of `writer`."""
        qos = self.qos(message, *policies)
        return DataReader(self.participant, self.topic(topic, message), qos)

    def any_reader(self, topic: str, message: type[Message]) -> DataReader[Message]:
        """Return a reader also of best-effort writers, such as those of sensors."""
        qos = self.qos(message, reliability=Policy.Reliability.BestEffort)
        return DataReader(self.participant, self.topic(topic, message), qos)

    def requests(self, service: str, message: type[Message]) -> DataWriter[Message]:
        """Return a writer of requests to a service; the arguments are those of `writer`."""
        topic = Topic(self.participant, self.request_topic(service), message)
        return DataWriter(self.participant, topic, self.qos(message))

    def request_topic(self, service: str) -> str:
        """Return the topic of the requests to a service, as DDS knows it."""
        return f"rq{self.name(service)}Request"

    def topic(self, topic: str, message: type[Message]) -> Topic[Message]:
        """Return a topic as ROS 2 names it."""
        return Topic(self.participant, f"rt{self.name(topic)}", message)

    def qos(
        self,
        message: type[Any],
        *policies: BasePolicy,
        reliability: BasePolicy = RELIABLE,
        mark: bytes = b"",
    ) -> Qos:
        """Return what a writer or a reader of messages offers or wants, as ROS 2 does."""
        return Qos(
            reliability,
            Policy.History.KeepLast(HISTORY_DEPTH),
            # ROS 2 does not read the newer representation.
            Policy.DataRepresentation(use_cdrv0_representation=True),
            Policy.Userdata(f"typehash={TYPE_HASHES[message]};".encode() + mark),
            *policies,
        )

    def _prefix(self) -> list[str]:
        return [part for part in self._namespace.split("/") if part]


def write(writer: DataWriter[Message], message: Message) -> None:
    """Publish a message; a slow reader is no error. Raises RobotError."""
    try:
        writer.write(message)
    except DDSException as error:
        if error.code != DDSException.DDS_RETCODE_TIMEOUT:
            raise RobotError(
                f"ROS 2: {writer.topic.name.removeprefix('rt')} cannot be published "
                f"({_short(error)}); start voz again"
            ) from error


def take(
    reader: DataReader[Message], most: int, condition: ReadCondition | None = None
) -> Iterator[Message]:
    """Take at most `most` messages that have arrived, without waiting; with a condition, those.

    Whoever is in the domain may send anything, and a name that is no UTF-8 must not end a run. So
    what cannot be read is dropped, and each is taken by itself: one would spoil all taken with it.
    """
    for _ in range(most):
        try:
            taken = reader.take(1, condition)  # type: ignore[arg-type]
        except DDSException:
            raise
        except Exception:  # cyclonedds raises many kinds
            continue
        if not taken:
            return
        yield from (one for one in taken if not isinstance(one, InvalidSample))  # a writer is gone


def all_acknowledged(writer: DataWriter[Any], seconds: float) -> bool:
    """Wait at most some seconds until all readers have acknowledged; return whether they have."""
    try:
        return bool(writer.wait_for_acks(round(seconds * 1e9)))
    except AttributeError:
        # cyclonedds 11.0 looks the code of a timeout up in the wrong class.
        return False


def _short(error: DDSException) -> str:
    return str(error).replace("\n", " ")
