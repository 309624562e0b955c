"""A participant of a ROS 2 domain, by Cyclone DDS, without ROS, and its discovery.

Cyclone's settings come from ROS's environment variables.
"""

from __future__ import annotations

import os
import re
import subprocess
import sys
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Any, TypeVar
from weakref import WeakValueDictionary
from xml.sax.saxutils import quoteattr

from cyclonedds.core import DDSException, ReadCondition
from cyclonedds.domain import Domain, DomainParticipant
from cyclonedds.idl import IdlStruct
from cyclonedds.internal import InvalidSample
from cyclonedds.pub import DataWriter
from cyclonedds.qos import BasePolicy, Policy, Qos
from cyclonedds.sub import DataReader
from cyclonedds.topic import Topic

from voz.errors import ConfigError, RobotError
from voz.files import MAX_SETTINGS_BYTES
from voz.ros2.message_types import TYPE_HASHES
from voz.settings import Ros2

MAX_LOCAL_PROGRAMS = 32
"""Programs on one computer that find each other without multicast, as in ROS 2's own Cyclone."""

MAX_SHOWN_DIGITS = 20
"""Characters of an invalid number that are shown."""

IGNORED_VENDORS = "1.15,1.16"
"""Fast DDS and Cyclone, by their vendor numbers.

ROS 2 matches types by name alone. Cyclone cannot read the type of a list from Fast DDS, and would
never connect to /diagnostics.
"""


def domain_number(settings: Ros2, environment: Mapping[str, str]) -> int:
    """Return the domain of the settings, or of `ROS_DOMAIN_ID`; ConfigError if that is invalid."""
    if settings.domain is not None:
        return settings.domain
    said = environment.get("ROS_DOMAIN_ID") or "0"
    if not said.isdecimal() or len(said) > MAX_SHOWN_DIGITS or int(said) > 232:
        raise ConfigError(
            f"ROS_DOMAIN_ID is {said[:MAX_SHOWN_DIGITS]!r}: set it to a number from 0 to 232"
        )
    return int(said)


def cyclone_settings(environment: Mapping[str, str]) -> str:
    """Write Cyclone's configuration so that it finds other programs as ROS 2's own does.

    Args:
        environment: `ROS_AUTOMATIC_DISCOVERY_RANGE`, `ROS_LOCALHOST_ONLY` and `ROS_STATIC_PEERS`
            mean what they mean to ROS 2; what `CYCLONEDDS_URI` says wins over them.

    Raises:
        ConfigError: there is no such range.
    """
    reach = environment.get("ROS_AUTOMATIC_DISCOVERY_RANGE") or "SUBNET"
    if environment.get("ROS_LOCALHOST_ONLY") == "1":
        reach = "LOCALHOST"
    if reach not in ("SUBNET", "LOCALHOST", "OFF", "SYSTEM_DEFAULT"):
        raise ConfigError(
            f"ROS_AUTOMATIC_DISCOVERY_RANGE is {reach!r}: "
            "set it to SUBNET, LOCALHOST, OFF or SYSTEM_DEFAULT"
        )
    own = environment.get("CYCLONEDDS_URI", "")
    found = _discovery(reach, environment, loopback=not _names_interfaces(own))
    names = f"<IgnoreTypeInformation>{IGNORED_VENDORS}</IgnoreTypeInformation>"
    return (
        f"<CycloneDDS><Domain><Compatibility>{names}</Compatibility>{found}</Domain></CycloneDDS>,"
        f"{own}"
    )


def _names_interfaces(uri: str) -> bool:
    """Whether the user chooses interfaces; Cyclone would add ours to those.

    `uri` has names of files and pieces of XML, with commas between them.
    """
    texts = [uri]
    for name in uri.split(","):  # pieces of XML are no files; Cyclone reports missing ones
        try:
            with Path(name.strip().removeprefix("file://")).open("rb") as file:
                texts.append(file.read(MAX_SETTINGS_BYTES).decode(errors="replace"))
        except (OSError, ValueError):
            continue
    said = re.sub(r"<!--.*?-->", "", "\n".join(texts), flags=re.DOTALL)
    return "<networkinterface" in said.lower()


def _discovery(reach: str, environment: Mapping[str, str], loopback: bool) -> str:
    if reach == "SYSTEM_DEFAULT":
        return ""
    if reach == "OFF":
        # Only a program with the same tag could find this one.
        return (
            "<General><AllowMulticast>false</AllowMulticast></General><Discovery>"
            f"<ParticipantIndex>none</ParticipantIndex><Tag>ros_discovery_off_{os.getpid()}</Tag>"
            "</Discovery>"
        )
    interfaces = '<Interfaces><NetworkInterface address="127.0.0.1"/></Interfaces>'
    here = (
        f"<General>{interfaces if loopback else ''}<AllowMulticast>false</AllowMulticast></General>"
    )
    named = environment.get("ROS_STATIC_PEERS", "").split(";")
    # Without a network there is no multicast, so this computer is always asked. By its number:
    # without an /etc/hosts nobody knows `localhost`, and Cyclone aborts the process.
    peers = "".join(f"<Peer address={quoteattr(p)}/>" for p in ["127.0.0.1", *filter(None, named)])
    return (
        f"{here if reach == 'LOCALHOST' else ''}"
        "<Discovery><ParticipantIndex>auto</ParticipantIndex>"
        f"<MaxAutoParticipantIndex>{MAX_LOCAL_PROGRAMS}</MaxAutoParticipantIndex>"
        f"<Peers>{peers}</Peers></Discovery>"
    )


CHECKED_VARIABLES = ("ROS_STATIC_PEERS", "CYCLONEDDS_URI")
"""What users write into Cyclone's configuration; the rest is valid."""

CHECK_PROGRAM = """
import resource, sys
from cyclonedds.domain import Domain
resource.setrlimit(resource.RLIMIT_CORE, (0, 0))
Domain(int(sys.argv[1]), sys.argv[2])
"""

CHECK_TIMEOUT = 20.0
"""Time limit for resolving the names, s."""


def check_cyclone(number: int, configuration: str, environment: Mapping[str, str]) -> None:
    """Raise ConfigError if Cyclone cannot make a domain with the users' environment variables.

    Another process tries: Cyclone aborts for a peer with an unknown name.
    """
    said = " and ".join(name for name in CHECKED_VARIABLES if environment.get(name))
    if not said:
        return
    command = [sys.executable, "-c", CHECK_PROGRAM, str(number), configuration]
    try:
        done = subprocess.run(
            command,
            stdin=subprocess.DEVNULL,
            capture_output=True,
            text=True,
            errors="replace",
            timeout=CHECK_TIMEOUT,
        )
    except (OSError, ValueError) as error:  # too long, or with a NUL in it
        raise ConfigError(f"{said} cannot be used ({error}); correct it") from error
    except subprocess.TimeoutExpired as error:
        raise ConfigError(f"{said}: no answer in {CHECK_TIMEOUT:g} s; correct it") from error
    if done.returncode:
        raise ConfigError(f"{said} cannot be used ({_reason(done.stderr)}); correct it")


def _reason(complaint: str) -> str:
    """Return the first line without the time, the domain and the program's name."""
    first = complaint.partition("\n")[0]
    return re.sub(r"^[\d.]+ \[\w*\]\s+\S+: ", "", first).strip() or "it ends the process"


Message = TypeVar("Message", bound=IdlStruct)

HISTORY_DEPTH = 10
"""Messages kept for a reader that does not keep up; ROS 2's own default."""

MAX_BLOCKING_TIME = 100_000_000
"""How long a full queue may block a message, ns: one beat."""

RELIABLE = Policy.Reliability.Reliable(max_blocking_time=MAX_BLOCKING_TIME)

FINAL_ACK_TIMEOUT = 0.3
"""How long an end waits for the last velocity to be acknowledged, s."""


class _Domain(Domain):
    """A domain, which ends with its object; its participants end before it.

    In a circle of objects Python calls `__del__` in any order, and takes the weak references away
    before, by which Cyclone's own objects know what to delete. Cyclone has crashed (seen once)
    where the domain was deleted with participants in it.
    """

    def __init__(self, number: int, configuration: str) -> None:
        super().__init__(number, configuration)
        self.participants: set[int] = set()

    def end(self, participant: int) -> None:
        """Delete a participant with all its entities, if that has not been done."""
        if participant in self.participants:
            self.participants.discard(participant)
            self._delete(participant)

    def __del__(self) -> None:
        if hasattr(self, "participants"):
            for participant in set(self.participants):
                self.end(participant)
            self._delete(self._ref)


_domains: WeakValueDictionary[int, _Domain] = WeakValueDictionary()
"""A process can be in a domain only once."""


class _Participant(DomainParticipant):
    """Keeps a reference to its domain, which ends with the last one."""

    def __init__(self, number: int) -> None:
        self._domain = _domains.get(number) or _domain(number)
        _domains[number] = self._domain
        super().__init__(number)
        self._domain.participants.add(self._ref)

    def __del__(self) -> None:
        if hasattr(self, "_ref"):
            self._domain.end(self._ref)


def _domain(number: int) -> _Domain:
    configuration = cyclone_settings(os.environ)
    check_cyclone(number, configuration, os.environ)
    return _Domain(number, configuration)


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
