"""The node `voz`: from the microphone to the robot in one process, for the latency."""

from __future__ import annotations

from functools import partial
from typing import NoReturn

from voz.inbox import Inbox
from voz.ros1.control_loop import replies, run_node_session
from voz.ros1.node import Ros1Node, read_settings, run_node
from voz.ros1.node_recognizer import load_recognizer, make_hearing
from voz.run.clocks import WallClock, warn
from voz.run.command_check import begins_listening, check_list
from voz.run.parts import answer_receiver


def run_voz(node: Ros1Node) -> None:
    """Drive by the microphone until the node is ended."""
    settings, recognizer = load_recognizer(read_settings())
    table = settings.table
    inbox = Inbox(table.halts)
    clock = WallClock(inbox)
    with (
        replies(settings.speech, table, partial(warn, inbox, clock)) as speech,
        make_hearing(recognizer, settings, inbox, clock.now, speech.loudspeaker) as hearing,
    ):
        check_list(recognizer.commands, table, "the list of commands")
        run_node_session(
            node,
            settings,
            hearing,
            [*speech.receivers, answer_receiver(recognizer)],
            inbox=inbox,
            clock=clock,
            listening=not begins_listening(recognizer.commands, table),
            says_heard=True,
        )


def main() -> NoReturn:
    """Run the node."""
    run_node("voz", run_voz)


if __name__ == "__main__":
    main()
