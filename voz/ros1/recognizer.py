"""The node `recognizer`, with the interface of the old package pocketsphinx."""

from __future__ import annotations

import queue
import threading
from collections.abc import Callable
from contextlib import ExitStack
from queue import SimpleQueue
from typing import Any, NoReturn

from voz.errors import VozError
from voz.events import Utterance, to_json
from voz.live.hearing import Hearing
from voz.live.messages import Halt, Message
from voz.ros1.driving import log
from voz.ros1.listening import make_hearing
from voz.ros1.node import Node, load_rospy
from voz.ros1.parameters import read_settings
from voz.ros1.program import clock_from_now, run_node

BEAT = 0.1
"""How often `~trouble` says that all is well, s."""

STOPPED = "the recogniser was stopped by its service"


class _Ears:
    """Hears from `start` to `stop`, which services call on threads of their own."""

    def __init__(self, inbox: SimpleQueue[Message], clock: Callable[[], float]) -> None:
        self._inbox = inbox
        self._clock = clock
        self._lock = threading.Lock()
        self._parts = ExitStack()
        self._hearing: Hearing | None = None

    def start(self) -> None:
        """Read the parameters and listen; if it did already, by what they are now."""
        hearing = make_hearing(read_settings(), self._inbox, self._clock)
        self.stop()
        with self._lock:
            self._parts.enter_context(hearing)
            self._hearing = hearing

    def stop(self) -> None:
        with self._lock:
            self._hearing = None
            self._parts.close()

    def trouble(self) -> str:
        """Tell why nothing is heard; empty if all is well."""
        hearing = self._hearing
        return hearing.trouble() or "" if hearing else STOPPED


def recognise(node: Node) -> None:
    """Publish what is understood until the node is ended."""
    import rospy
    from std_msgs.msg import String
    from std_srvs.srv import Empty

    inbox: SimpleQueue[Message] = SimpleQueue()
    clock = clock_from_now()
    ears = _Ears(inbox, clock)
    ears.start()
    output = rospy.Publisher("~output", String, queue_size=10, tcp_nodelay=True)
    refused = rospy.Publisher("~refused", String, queue_size=10)
    trouble = rospy.Publisher("~trouble", String, queue_size=1)
    rospy.Service("~start", Empty, _service(ears.start))
    rospy.Service("~stop", Empty, _service(ears.stop))
    due, told = 0.0, ""
    try:
        while not node.over:
            if clock() >= due:
                told = _tell(told, ears.trouble(), trouble)
                due = clock() + BEAT
            try:
                event = inbox.get(timeout=max(0.0, due - clock()))
            except queue.Empty:
                continue
            if not isinstance(event, Halt):
                log(event)
            if isinstance(event, Utterance):
                if event.accepted:
                    output.publish(event.text)
                else:
                    refused.publish(to_json(event))
    finally:
        ears.stop()


def _tell(before: str, now: str, publisher: Any) -> str:
    """Tell what is wrong, or that all is well; the log is told only when that changes."""
    publisher.publish(now)
    if now != before:
        load_rospy().logwarn(now or "listening again")
    return now


def _service(act: Callable[[], None]) -> Callable[[Any], Any]:
    """A service that does something; what is wrong with it is the caller's to know."""
    from rospy import ServiceException
    from std_srvs.srv import EmptyResponse

    def serve(_request: Any) -> Any:
        try:
            act()
        except VozError as error:
            raise ServiceException(str(error)) from error
        return EmptyResponse()

    return serve


def main() -> NoReturn:
    """Run the node."""
    run_node("recognizer", recognise)


if __name__ == "__main__":
    main()
