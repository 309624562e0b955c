"""The node `recognizer`, with the interface of the old package pocketsphinx."""

from __future__ import annotations

import threading
from collections.abc import Callable
from contextlib import ExitStack
from typing import Any, NoReturn

from voz.control.messages import End, Halt, Rehearsal, Renewal
from voz.errors import ConfigError, VozError
from voz.events import Event, Notice, Receiver, Utterance, to_json
from voz.hearing.microphone_thread import Hearing
from voz.inbox import Inbox
from voz.process.signals import defer_signals
from voz.ros1.control_loop import log_receiver
from voz.ros1.node import Ros1Node, read_settings, run_node
from voz.ros1.node_recognizer import load_recognizer, make_hearing
from voz.ros1.own_messages import RecognizerStatus
from voz.run.clocks import WallClock

TROUBLE_INTERVAL = 0.1
"""How often `~trouble` says that all is well, s."""

STOPPED = "the recognizer was stopped by its service"


class SwitchedHearing:
    """Listens from `start` to `stop`; services call these on threads of their own."""

    def __init__(self, inbox: Inbox, clock: Callable[[], float]) -> None:
        self._inbox = inbox
        self._clock = clock
        self._lock = threading.Lock()
        self._parts = ExitStack()
        self._hearing: Hearing | None = None

    def start(self) -> None:
        """Read the parameters and listen; again, if it listens already."""
        settings = read_settings()
        if settings.recognition.more_than_commands:
            raise ConfigError(
                "`name` and `ask` of [recognition] need recognizer and control in one node",
                "start the node `voz` instead, or `control_voz.launch` with one_process:=true",
            )
        settings, recognizer = load_recognizer(settings)
        hearing = make_hearing(recognizer, settings, self._inbox, self._clock)
        with self._lock:  # all the while: of two at once, both would hear
            self._end()
            self._parts.enter_context(hearing)
            self._hearing = hearing

    def stop(self) -> None:
        """Listen no more."""
        with self._lock:
            self._end()

    def _end(self) -> None:
        self._hearing = None
        self._parts.close()

    @property
    def status(self) -> RecognizerStatus:
        """Whether it listens, and what is wrong."""
        hearing = self._hearing
        if hearing is None:
            return RecognizerStatus(STOPPED)
        # Silence matters only while the robot moves, which only the other node knows.
        return RecognizerStatus(hearing.trouble(moving=False) or "", hearing.only_silence)


def recognize(node: Ros1Node) -> None:
    """Publish what is understood until the node is ended."""
    import rospy
    from std_msgs.msg import String
    from std_srvs.srv import Empty

    inbox = Inbox(read_settings().table.halts)
    clock = WallClock(inbox)
    hearing = SwitchedHearing(inbox, clock.now)
    with ExitStack() as parts:
        parts.callback(hearing.stop)
        hearing.start()
        output = rospy.Publisher("~output", String, queue_size=10, tcp_nodelay=True)
        refused = rospy.Publisher("~refused", String, queue_size=10)
        trouble = rospy.Publisher("~trouble", String, queue_size=1)
        rospy.Service("~start", Empty, _service(hearing.start))
        rospy.Service("~stop", Empty, _service(hearing.stop))
        node.on_shutdown(lambda: inbox.put(End()))
        log = parts.enter_context(log_receiver(inbox.put))
        parts.enter_context(defer_signals(lambda: inbox.put(End())))
        status, due = RecognizerStatus(), 0.0
        while True:
            message = clock.next_before(due)
            if message is None:
                before, status = status, hearing.status
                trouble.publish(status.text)
                if status.problem != before.problem:
                    text, good = status.problem or "listening again", not status.problem
                    log(Notice(clock.now(), text, good))
                due = clock.now() + TROUBLE_INTERVAL
            elif isinstance(message, End):
                if message.error:
                    raise message.error
                return
            elif not isinstance(message, Halt | Rehearsal | Renewal):
                _report(message, output, refused, log)


def _report(event: Event, output: Any, refused: Any, log: Receiver) -> None:
    """Publish an utterance; log what no subscriber will log."""
    if isinstance(event, Utterance) and event.accepted and not event.ignored:
        if not output.get_num_connections():
            log(event)
        output.publish(event.text)
        return
    log(event)
    if isinstance(event, Utterance):
        refused.publish(to_json(event))


def _service(act: Callable[[], None]) -> Callable[[Any], Any]:
    """Make a service; its errors go to the caller."""
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
    run_node("recognizer", recognize)


if __name__ == "__main__":
    main()
