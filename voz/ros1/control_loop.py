"""What the nodes that drive have in common: who receives what follows from what is heard."""

from __future__ import annotations

import sys
from collections.abc import Callable
from contextlib import ExitStack, nullcontext
from typing import Protocol

from msgspec.structs import replace

from voz.config import Config
from voz.events import Event, Partial, Receiver, Twist, Warning
from voz.inbox import End, Inbox
from voz.language.sentences.command_set import Commands
from voz.printable import printable
from voz.robot.console import in_words
from voz.robot.factory import mailboxes
from voz.robot.robot_process import RobotProcess, RobotSpec
from voz.ros1.node import Ros1Node, load_rospy
from voz.ros1.parameters import switch
from voz.ros1.robot import Ros1Robot
from voz.run.clocks import Clock
from voz.run.command_check import begins_listening
from voz.run.queued import Queued
from voz.run.session import Ears, OpenRobots, Session, starting_programs

KEPT = ("__ns:=", "__ip:=", "__hostname:=", "__master:=")
"""What a node's watchdog has of its special arguments; its name, log and parameters it has not."""


class KnowingEars(Ears, Protocol):
    """What hears, and knows what may be said."""

    @property
    def commands(self) -> Commands:
        """What may be said."""


def drive(
    node: Ros1Node,
    settings: Config,
    ears: KnowingEars,
    say: list[Receiver],
    *,
    inbox: Inbox,
    clock: Clock,
    says_heard: bool,
) -> None:
    """Drive the robot by what comes into the inbox, until the node is ended.

    Args:
        node: this process's.
        settings: the topics and the safety rules.
        ears: what hears.
        say: says the replies.
        inbox: what is heard.
        clock: the time of the run.
        says_heard: whether the node publishes what is obeyed.
    """
    table = settings.table
    listening = bool(switch("listening")) or not begins_listening(ears.commands, table)
    robots = {
        "ROS": Ros1Robot(settings.ros1, node, (), says_heard, table),
        "watchdog": RobotProcess(_order(node, settings), load_rospy().loginfo),
    }
    with ExitStack() as parts:
        boxes = parts.enter_context(mailboxes(robots, lambda line: load_rospy().logwarn(line)))
        log = parts.enter_context(logged(inbox.put))
        node.before_the_end(lambda: inbox.put(End()))
        start = parts.enter_context(starting_programs(table, inbox, clock, load_rospy().loginfo))
        receivers = [*(box.receive for box in boxes.values()), *say, log, start]
        troubles = {name: box.lost for name, box in boxes.items()}
        session = Session(settings, clock, listening)
        session.add_robots(OpenRobots(receivers, troubles, robots["ROS"].place))
        session.watch_ears(ears)
        session.run_in_real_time(inbox)


def logged(tell: Callable[[Warning | End], None]) -> Queued:
    """What writes events into ROS's log, which may be a terminal or a disk that is slow."""
    return Queued("the log", nullcontext(_log), tell)


def _log(event: Event) -> None:
    """Write what happens, but for the velocity, which has its topic."""
    if isinstance(event, Warning) and not event.good:
        load_rospy().logwarn(printable(event.text))
    elif not isinstance(event, Twist | Partial):
        load_rospy().loginfo(printable(" ".join(in_words(event).split())))


def _order(node: Ros1Node, settings: Config) -> RobotSpec:
    """The watchdog of a node: a node beside it, with its remappings but a name of its own."""
    name = node.name.rpartition("/")[2]
    remapped = [a for a in sys.argv[1:] if a.startswith(KEPT) or not a.startswith("_")]
    ros1 = replace(settings.ros1, node=name)
    return RobotSpec(
        "ros1", replace(settings, ros1=ros1), only_zero=True, arguments=tuple(remapped)
    )
