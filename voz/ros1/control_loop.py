"""The run of the nodes that control a robot, and the replies that these give."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from contextlib import contextmanager, nullcontext
from dataclasses import dataclass
from functools import partial
from pathlib import Path

from voz.audio.loudspeaker import Mixer
from voz.config import Config
from voz.control.messages import End
from voz.control.table import CommandTable
from voz.events import Attention, Event, Notice, Partial, Play, Receiver, Reply, Twist
from voz.inbox import Inbox
from voz.printable import printable
from voz.robot.console import attention_changes, in_words
from voz.robot.factory import open_mailboxes
from voz.robot.robot_process import RobotProcess, RobotSpec
from voz.ros1.node import (
    Ros1Node,
    choice_parameter,
    load_rospy,
    switch_parameter,
    watchdog_arguments,
)
from voz.ros1.robot import Ros1Robot
from voz.run.clocks import Clock
from voz.run.controller import controller_by
from voz.run.parts import QueuedReceiver, speaker_receiver, start_programs
from voz.run.session import Session, SpeechInput
from voz.run.spec import RunSpec
from voz.settings import Speech
from voz.speech.reply_speaker import ReplySpeaker


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

    The speech input is watched. Commands are obeyed before a `start speech` if `listening`, or
    `~listening`, is true. `says_heard` is whether the node publishes what is obeyed; `say` are the
    receivers that speak.
    """
    table = settings.table
    watchdog = RobotSpec("ros1", settings, only_zero=True, arguments=watchdog_arguments(node.name))
    robots = {
        "ROS": Ros1Robot(settings.ros1, node, (), says_heard, table=table, warn=inbox.put),
        "watchdog": RobotProcess(watchdog, load_rospy().loginfo),
    }

    @contextmanager
    def connect(session: Session) -> Iterator[None]:
        with open_mailboxes(robots, lambda line: load_rospy().logwarn(line)) as boxes:
            for name, box in boxes.items():
                session.receivers.append(box.receive)
                session.watch(name, box.lost)
            session.receivers += say
            with log_receiver(inbox.put) as log:
                session.receivers.append(log)
                session.show = load_rospy().loginfo
                session.controller.odometry = robots["ROS"].place
                node.on_shutdown(lambda: inbox.put(End()))
                session.watch_input(speech_input)
                yield

    spec = RunSpec(
        controller=controller_by(settings, listening or bool(switch_parameter("listening"))),
        settings=settings,
        inbox=inbox,
        clock=lambda _: clock,
        outputs=[connect],
        parts=[start_programs],
    )
    Session(spec).run()


def log_receiver(tell: Callable[[Notice | End], None]) -> QueuedReceiver:
    """Return a receiver that logs events on its own thread: ROS's log may be slow."""
    return QueuedReceiver("the log", nullcontext(partial(_log, attention_changes())), tell)


def _log(is_news: Callable[[Attention], bool], event: Event) -> None:
    if isinstance(event, Attention) and not is_news(event):
        return
    if isinstance(event, Notice) and not event.good:
        load_rospy().logwarn(printable(event.text))
    elif not isinstance(event, Twist | Partial):
        load_rospy().loginfo(printable(" ".join(in_words(event).split())))


@dataclass(frozen=True)
class Replies:
    """Receivers that play replies and sounds, and the loudspeaker of this process if it does."""

    receivers: list[Receiver]
    loudspeaker: Mixer | None = None


@contextmanager
def replies(
    settings: Speech, table: CommandTable, warn: Callable[[str], None]
) -> Iterator[Replies]:
    """Let the replies be said, by `~sound`: `voz`, `ros` or `none`; render the known ones first."""
    sound = choice_parameter("sound", ("voz", "ros", "none")) if settings.enabled else "none"
    if sound == "ros":
        yield Replies([_replies_on_robotsound(settings.voice)])
        return
    if sound == "none":
        yield Replies([])
        return
    with ReplySpeaker(settings.voice, table.replies, warn, barge_in=settings.barge_in) as speaker:
        yield Replies([speaker_receiver(speaker, table.halts)], speaker.mixer)


def _replies_on_robotsound(voice: str) -> Receiver:
    from rospy import Publisher

    from voz.ros1.own_messages import ONCE, PLAY_FILE, SAY, TOPIC, sound_request
    from voz.speech.builtin_sounds import BuiltinSound

    kind = sound_request()
    publisher = Publisher(TOPIC, kind, queue_size=10)
    builtin = {sound.title: int(sound) for sound in BuiltinSound}

    def receive(event: Event) -> None:
        if isinstance(event, Reply):
            publisher.publish(kind(SAY, ONCE, 1.0, event.text, f"voice_{voice}"))
        elif isinstance(event, Play) and event.sound in builtin:
            publisher.publish(kind(builtin[event.sound], ONCE, 1.0, "", ""))
        elif isinstance(event, Play):
            publisher.publish(kind(PLAY_FILE, ONCE, 1.0, str(Path(event.sound).resolve()), ""))

    return receive
