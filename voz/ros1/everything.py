"""The node `voz`: from the microphone to the robot in one process, for the latency."""

from __future__ import annotations

from queue import SimpleQueue
from typing import NoReturn

from voz.live.messages import Message
from voz.ros1.driving import drive
from voz.ros1.listening import make_hearing
from voz.ros1.node import Node
from voz.ros1.parameters import read_settings
from voz.ros1.program import clock_from_now, run_node
from voz.ros1.replies import replies


def listen_and_drive(node: Node) -> None:
    """Drive by the microphone until the node is ended."""
    settings = read_settings()
    inbox: SimpleQueue[Message] = SimpleQueue()
    clock = clock_from_now()
    with (
        replies(settings.speech) as speech,
        make_hearing(settings, inbox, clock, speech.loudspeaker) as hearing,
    ):
        drive(node, settings, speech, inbox, clock, hearing.trouble, says_heard=True)


def main() -> NoReturn:
    """Run the node."""
    run_node("voz", listen_and_drive)


if __name__ == "__main__":
    main()
