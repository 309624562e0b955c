"""What the nodes that drive have in common: a drive that publishes, and says and logs the rest."""

from __future__ import annotations

import sys
from collections.abc import Callable
from contextlib import ExitStack

from voz.config import Config
from voz.control.safety import zero_at_the_end
from voz.drive import Drive
from voz.events import Event, Partial, Twist, Warning
from voz.live.loop import drive_live, stamp
from voz.live.messages import Inbox
from voz.robot.console import in_words
from voz.robot.ros1 import Ros1Robot
from voz.ros1.node import Node, load_rospy
from voz.ros1.parameters import switch
from voz.ros1.replies import Replies
from voz.watch import over_robots


def drive(
    node: Node,
    settings: Config,
    speech: Replies,
    inbox: Inbox,
    clock: Callable[[], float],
    unheard: Callable[[], str | None],
    says_heard: bool,
) -> None:
    """Drive the robot by what comes into the inbox, until the node is ended.

    Args:
        node: this process's.
        settings: the topics and the safety rules.
        speech: says the replies.
        inbox: what is heard.
        clock: the time of the run, s.
        unheard: tells why nothing is heard right now (S5).
        says_heard: whether the node publishes what is obeyed.
    """
    robot = Ros1Robot(settings.ros1, node, says_heard=says_heard)

    def trouble() -> str | None:
        if node.over:
            sys.exit(0)
        for problem in speech.problems():
            driven.emit(Warning(stamp(clock()), problem))
        return unheard()

    with ExitStack() as parts:
        parts.callback(robot.close)
        robot.open()
        node.end_between_messages()
        driven = Drive(
            [robot.receive, speech.receive, log], settings.safety, bool(switch("listening"))
        )
        parts.enter_context(zero_at_the_end(lambda: driven.zero(stamp(clock()))))
        drive_live(driven, inbox, trouble, clock, over_robots(driven, {"ROS": robot.lost}))


def log(event: Event) -> None:
    """Write what happens into ROS's log, but for the velocity, which has its topic."""
    if isinstance(event, Warning):
        load_rospy().logwarn(event.text)
    elif not isinstance(event, Twist | Partial):
        load_rospy().loginfo(" ".join(in_words(event).split()))
