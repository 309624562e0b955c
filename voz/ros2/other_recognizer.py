"""Commands that another recognizer publishes as ROS 2 texts; what it hears may drive too."""

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
from voz.ros2.node import Ros2Node
from voz.settings import Ros2

HEARD_ON_ROS = "ros2"
"""The source of such an utterance. It is not published again, or two programs would never end."""


@contextmanager
def heard_on_ros(
    settings: Ros2, heard: Callable[[str], None], failed: Callable[[str], None]
) -> Iterator[None]:
    """Listen to the topic of commands for the length of a `with` block.

    Args:
        settings: the domain and the topic.
        heard: called with each text, in a thread of its own; not with what this process publishes.
        failed: called there, too, with a line that says why nothing is heard any more.

    Raises:
        ConfigError: the environment says what cannot be.
        RobotError: the domain cannot be joined.
    """
    node = Ros2Node(settings)
    reader = node.reader(settings.output, String, Policy.IgnoreLocal.Process)
    end = GuardCondition(node.participant)

    def listen() -> None:
        try:
            _listen(node, reader, end, heard)
        except BaseException as error:  # whatever it is: a `stop` may be lost
            failed(f"what is published on {settings.output} is heard no more ({error!r})")

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
        for text in _waiting(reader):
            heard(text)


def _waiting(reader: DataReader[String]) -> Iterator[str]:
    while True:
        try:
            samples = reader.take(1)
        except UnicodeDecodeError:
            continue  # a command it was not
        if not samples:
            return
        # That a writer has gone is told by a sample without a message.
        yield from (sample.data for sample in samples if isinstance(sample, String))
