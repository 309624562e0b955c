"""Asks the ROS master, with a time limit: rospy itself waits for one for ever."""

from __future__ import annotations

import http.client
import os
import re
import xmlrpc.client
from typing import Any
from urllib.parse import urlsplit

from voz.errors import ConfigError

PATIENCE = 1.0
"""For an answer, s; a master that is there takes a thousandth of it."""


def master_uri() -> str:
    """Where the master is to be."""
    return os.environ.get("ROS_MASTER_URI") or "http://localhost:11311"


def check_namespace() -> None:
    """Refuse a namespace that no master takes: with one of those rospy never begins or ends.

    Raises:
        ConfigError: it cannot be.
    """
    said = os.environ.get("ROS_NAMESPACE", "")
    if not re.fullmatch(r"(/?[A-Za-z]\w*(/\w+)*)?/?", said, re.ASCII):
        raise ConfigError(f"ROS_NAMESPACE is {said!r}: set it to a name like /robot1")


def ask(method: str, *arguments: str, patience: float = PATIENCE) -> Any:
    """Call a method of the master's.

    Args:
        method: one of https://wiki.ros.org/ROS/Master_API.
        arguments: what it takes, the caller's name first.
        patience: how long to wait for the answer, s.

    Returns:
        Its value; None if the master refuses, as it does for a node that it does not know.

    Raises:
        OSError: there is no master, or it does not answer.
    """
    uri = master_uri()
    if not _is_address(uri):
        raise OSError("ROS_MASTER_URI is no address like http://localhost:11311")
    try:
        with xmlrpc.client.ServerProxy(uri, _Transport(patience)) as master:
            code, _, value = getattr(master, method)(*arguments)
    except (xmlrpc.client.Error, http.client.HTTPException, ValueError, TypeError) as error:
        raise OSError("what answers there is no ROS master") from error
    return value if code == 1 else None


def _is_address(uri: str) -> bool:
    try:
        parts = urlsplit(uri)
        return bool(parts.hostname) and parts.port != 0
    except ValueError:  # half a bracket, or a port that is no number
        return False


class _Transport(xmlrpc.client.Transport):
    """HTTP that gives up after a time."""

    def __init__(self, patience: float) -> None:
        super().__init__()
        self._patience = patience

    def make_connection(self, host: Any) -> http.client.HTTPConnection:
        connection = super().make_connection(host)
        connection.timeout = self._patience
        return connection
