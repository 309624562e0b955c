"""The run of the nodes that control a robot."""

from __future__ import annotations

from collections.abc import Callable
from contextlib import ExitStack, nullcontext

from voz.config import Config
from voz.events import Event, Notice, Partial, Receiver, Twist
from voz.inbox import End, Inbox
from voz.printable import printable
from voz.robot.console import in_words
from voz.robot.factory import open_mailboxes
from voz.robot.robot_process import RobotProcess, RobotSpec
from voz.ros1.arguments import watchdog_arguments
from voz.ros1.node import Ros1Node, load_rospy
from voz.ros1.parameters import switch
from voz.ros1.robot import Ros1Robot
from voz.run.clocks import Clock
from voz.run.queued import QueuedReceiver
from voz.run.session import OpenRobots, SpeechInput, new_session, open_programs


def run_node_session(
    node: Ros1Node,
    settings: Config,
    speech_input: SpeechInput,
    say: list[Receiver],
    *,
    inbox: Inbox,
    clock: Clock,
    listening: bool,
    says_heard: bool,
) -> None:
    """Control the robot by the messages of the inbox, until the node is ended.

    Args:
        node: the node of this process.
        settings: the topics and the safety rules.
        speech_input: where commands come from, to be watched.
        say: receivers that speak.
        inbox: commands.
        clock: of the run.
        listening: whether commands are obeyed before a `start speech`; `~listening` says so, too.
        says_heard: whether the node publishes what is obeyed.
    """
    table = settings.table
    watchdog = RobotSpec("ros1", settings, only_zero=True, arguments=watchdog_arguments(node.name))
    robots = {
        "ROS": Ros1Robot(settings.ros1, node, (), says_heard, table, inbox.put),
        "watchdog": RobotProcess(watchdog, load_rospy().loginfo),
    }
    with ExitStack() as parts:
        boxes = parts.enter_context(open_mailboxes(robots, lambda line: load_rospy().logwarn(line)))
        log = parts.enter_context(log_receiver(inbox.put))
        node.on_shutdown(lambda: inbox.put(End()))
        programs = parts.enter_context(open_programs(table, inbox, clock, load_rospy().loginfo))
        receivers = [*(box.receive for box in boxes.values()), *say, log, programs.receive]
        troubles = {name: box.lost for name, box in boxes.items()}
        session = new_session(settings, clock, listening or bool(switch("listening")))
        session.add_robots(OpenRobots(receivers, troubles, robots["ROS"].place))
        session.watch_input(speech_input)
        session.run_in_real_time(inbox)


def log_receiver(tell: Callable[[Notice | End], None]) -> QueuedReceiver:
    """Return a receiver that logs events on its own thread: ROS's log may be slow."""
    return QueuedReceiver("the log", nullcontext(_log), tell)


def _log(event: Event) -> None:
    if isinstance(event, Notice) and not event.good:
        load_rospy().logwarn(printable(event.text))
    elif not isinstance(event, Twist | Partial):
        load_rospy().loginfo(printable(" ".join(in_words(event).split())))
