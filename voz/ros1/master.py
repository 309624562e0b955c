"""Calls the ROS master, with a time limit; rospy itself waits forever."""

from __future__ import annotations

import http.client
import os
import re
import socket
import xmlrpc.client
from collections.abc import Set
from typing import Any
from urllib.parse import urlsplit
from xml.parsers.expat import ExpatError

from voz.errors import ConfigError

MASTER_TIMEOUT = 1.0
"""Limit for an answer, s; a master takes a millisecond."""

WATCHDOG = "_watchdog"
"""How the name of a watchdog ends; before it is the name of the node that it watches."""

NOT_AN_ANSWER = (
    xmlrpc.client.Error,
    http.client.HTTPException,
    ExpatError,
    ValueError,
    TypeError,
)
"""What xmlrpc raises for what a master does not say."""

NO_MASTER = "the server there is not a ROS master"


def master_uri() -> str:
    """Return the address of the master."""
    return os.environ.get("ROS_MASTER_URI") or "http://localhost:11311"


def check_namespace(said: str | None = None, place: str = "ROS_NAMESPACE") -> None:
    """Raise ConfigError for an invalid namespace, with which rospy never starts or ends.

    None takes that of the environment; `place` is what says so, for the message.
    """
    said = os.environ.get("ROS_NAMESPACE", "") if said is None else said
    if not re.fullmatch(r"(/?[A-Za-z]\w*(/\w+)*)?/?", said, re.ASCII):
        raise ConfigError(f"{place} is {said!r}: set it to a name like /robot1")


def ask(method: str, *arguments: str, timeout: float = MASTER_TIMEOUT) -> Any:
    """Call a method of https://wiki.ros.org/ROS/Master_API, the caller's name first.

    Returns:
        Its value; None if the master refuses, as for an unknown node.

    Raises:
        OSError: there is no master, or it does not answer within `timeout` s.
    """
    uri = master_uri()
    if not is_address(uri):
        raise OSError("invalid ROS_MASTER_URI; set it to an address like http://localhost:11311")
    try:
        with xmlrpc.client.ServerProxy(uri, _Transport(timeout)) as master:
            code, _, value = getattr(master, method)(*arguments)
    except NOT_AN_ANSWER as error:
        raise OSError(NO_MASTER) from error
    return value if code == 1 else None


def system_state(caller: str) -> tuple[dict[str, list[str]], dict[str, list[str]]]:
    """Return the publishers and the subscribers of each topic; raises OSError."""
    try:
        publishers, subscribers, _ = ask("getSystemState", caller) or ([], [], [])
        return dict(publishers), dict(subscribers)
    except NOT_AN_ANSWER as error:
        raise OSError(NO_MASTER) from error


def other_senders(topic: str, node: str) -> Set[str]:
    """Return the nodes that publish a topic besides one; raises OSError.

    A watchdog of voz's does not count: it sends only zero, and only when its node is silent. Nor
    does a node that was killed, which the master goes on naming.
    """
    publishers, _ = system_state(node)
    names = {node, *publishers.get(topic, ())}
    others = {
        name
        for name in names - {node}
        if not (name.endswith(WATCHDOG) and name.removesuffix(WATCHDOG) in names)
    }
    return frozenset(name for name in others if not _is_gone(ask("lookupNode", node, name)))


def _is_gone(uri: str | None) -> bool:
    """Whether nobody is where a node was; if that is not known, it may be there."""
    if uri is None:
        return True
    try:
        place = urlsplit(uri)
        socket.create_connection((place.hostname, place.port or 80), MASTER_TIMEOUT).close()
    except ConnectionRefusedError:
        return True
    except (OSError, ValueError):
        return False
    return False


def is_address(uri: str) -> bool:
    """Whether this may be the address of a master."""
    try:
        parts = urlsplit(uri)
        return bool(parts.hostname) and parts.port != 0
    except ValueError:  # half a bracket, or a port that is no number
        return False


class _Transport(xmlrpc.client.Transport):
    """HTTP that gives up after a time."""

    def __init__(self, timeout: float) -> None:
        super().__init__()
        self._timeout = timeout

    def make_connection(self, host: Any) -> http.client.HTTPConnection:
        connection = super().make_connection(host)
        connection.timeout = self._timeout
        return connection
