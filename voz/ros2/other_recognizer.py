"""Receives commands that another recognizer publishes as ROS 2 strings."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from contextlib import contextmanager
from threading import Thread

from cyclonedds.core import (
    GuardCondition,
    InstanceState,
    ReadCondition,
    SampleState,
    ViewState,
    WaitSet,
)
from cyclonedds.qos import Policy
from cyclonedds.sub import DataReader
from cyclonedds.util import duration

from voz.ros2.message_types import String
from voz.ros2.node import Ros2Node, take
from voz.settings import Ros2

ROS2_SOURCE = "ros2"
"""The source of such an utterance, which is not published again: two programs would never end."""

MAX_TAKEN = 100
"""Texts at a time, between two looks for the end."""


@contextmanager
def listen_to_recognizer(
    settings: Ros2, heard: Callable[[str], None], failed: Callable[[str], None]
) -> Iterator[None]:
    """Listen to the topic of commands for a `with` block, on a thread of its own.

    There `heard` is called with each text of other processes, and `failed` with a line if that
    thread ends by an error.
    """
    node = Ros2Node(settings)
    reader = node.reader(settings.output, String, Policy.IgnoreLocal.Process)
    end = GuardCondition(node.participant)

    def listen() -> None:
        try:
            _listen(node, reader, end, heard)
        except BaseException as error:  # whatever it is: a `stop` may be lost
            failed(f"{settings.output} is no longer received ({error!r})")

    thread = Thread(target=listen, name="voz-ros2", daemon=True)
    thread.start()
    try:
        yield
    finally:
        end.set(True)
        thread.join()


def _listen(
    node: Ros2Node, reader: DataReader[String], end: GuardCondition, heard: Callable[[str], None]
) -> None:
    something = WaitSet(node.participant)
    arrived = ReadCondition(reader, ViewState.Any | InstanceState.Any | SampleState.NotRead)
    something.attach(arrived)
    something.attach(end)
    while not end.read():
        something.wait(duration(seconds=3600))
        for message in take(reader, MAX_TAKEN):  # what is left wakes it again
            heard(message.data)
