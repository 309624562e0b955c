"""What a robot on ROS 2 publishes, who listens, and whose goals are canceled."""

from __future__ import annotations

import os
import signal
import subprocess
import sys
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from math import pi, sqrt
from pathlib import Path
from socket import gethostname
from threading import Timer
from typing import Any

import pytest
from cyclonedds.idl import IdlStruct
from cyclonedds.qos import Policy
from cyclonedds.sub import DataReader
from cyclonedds.topic import Topic
from programs import Program, wait_until
from ros2.conftest import ORDINARY, RCLPY

from voz.config import Config
from voz.errors import ConfigError
from voz.events import Attention, Event, Notice, Partial, Reply, SelectedObject, Twist, Utterance
from voz.extras import how_to_install
from voz.robot.robot_process import RobotSpec
from voz.robot.ros_topics import ONE_SENDER
from voz.robot.simulation.world import Pose2D, WorldState
from voz.ros2 import ROS2_SOURCE, Ros2Robot
from voz.ros2 import message_types as msg
from voz.ros2.base_topics import Ros2Watchdog, VelocityTopic
from voz.ros2.message_types import CycloneCancelAllGoals
from voz.ros2.node import Ros2Node
from voz.settings import Ros2

pytestmark = pytest.mark.usefixtures("domain")

NOW = Ros2(wait=0)
COMM = Path("/proc/self/comm").read_text().strip()
SOMEBODY = f"process {os.getpid()} ({COMM}) on {gethostname()}"
"""This one: it has no node's name."""


@contextmanager
def opened(settings: Ros2 = NOW) -> Iterator[tuple[Ros2Robot, list[Notice]]]:
    told: list[Notice] = []
    robot = Ros2Robot(settings, told.append)
    robot.open()
    try:
        yield robot, told
    finally:
        robot.close()


def reader(topic: str, message: type[Any], *policies: Any, domain: int | None = None) -> Any:
    return Ros2Node(Ros2(domain=domain)).reader(topic, message, *policies)


def heard(reader: DataReader[Any]) -> list[Any]:
    return list(reader.take(1000))


def said(text: str, accepted: bool = True, source: str = "microphone") -> Utterance:
    return Utterance(0.0, text, 0.9, accepted, 0.0, 0.0, source, obeyed=accepted)


def test_velocities_arrive_exactly() -> None:
    velocities = [(0.1, 0.0), (-0.15, 0.1), (0.0, -1.0), (0.0, 0.0)]
    with opened() as (robot, _):
        base = reader("cmd_vel", msg.TwistMessage)
        for linear, angular in velocities:
            robot.receive(Twist(0.0, linear, angular))
    assert heard(base) == [
        msg.TwistMessage(msg.Vector3(linear, 0, 0), msg.Vector3(0, 0, angular))
        for linear, angular in velocities
    ]


def test_a_stamped_velocity_has_the_time_of_day_and_a_frame() -> None:
    with opened(Ros2(wait=0, stamped=True, frame_id="base")) as (robot, _):
        base = reader("cmd_vel", msg.TwistStamped)
        before = time.time_ns()
        robot.receive(Twist(0.0, 0.2, 0.1))
        after = time.time_ns()
    (message,) = heard(base)
    assert message.twist.linear.x == 0.2
    assert message.twist.angular.z == 0.1
    assert message.header.frame_id == "base"
    stamp = message.header.stamp
    assert before <= stamp.sec * 1_000_000_000 + stamp.nanosec <= after


def test_the_arm_gets_its_objects() -> None:
    with opened() as (robot, _):
        arm = reader("selected_object", msg.Int16)
        for value in (1, 2, 100):
            robot.receive(SelectedObject(0.0, value))
    assert [message.data for message in heard(arm)] == [1, 2, 100]


def test_whether_it_is_awake_is_known_to_who_subscribes_later() -> None:
    late = Policy.Durability.TransientLocal
    with opened() as (robot, _):
        for awake in (False, True):
            robot.receive(Attention(0.0, awake))
        assert heard(reader("recognizer/awake", msg.Bool, late))[-1] == msg.Bool(True)


def test_where_a_simulated_robot_is_is_published_with_each_velocity() -> None:
    robot = Ros2Robot(Ros2(wait=0, namespace="robot1", frame_id="base"))
    robot.where = lambda t: WorldState(t, Pose2D(t, -0.5, pi / 2), 0.1, -0.2)
    robot.open()
    odom = reader("/robot1/odom", msg.Odometry)
    tf = reader("/tf", msg.TFMessage)
    before = time.time_ns()
    for t in (1.0, 2.0):
        robot.receive(Twist(t, 0.0, 0.0))
    after = time.time_ns()
    robot.close()
    half = sqrt(0.5)
    transforms = [transform for message in heard(tf) for transform in message.transforms]
    for t, odometry, transform in zip((1.0, 2.0), heard(odom), transforms, strict=True):
        turned = odometry.pose.pose.orientation
        assert odometry.pose.pose.position == msg.Point(t, -0.5)
        assert (turned.x, turned.y, turned.z, turned.w) == pytest.approx((0, 0, half, half))
        assert odometry.twist.twist == msg.velocity(0.1, -0.2)
        assert transform.transform == msg.Transform(msg.Vector3(t, -0.5), turned)
        assert transform.header == odometry.header
        assert (odometry.header.frame_id, odometry.child_frame_id) == ("odom", "base")
        assert transform.child_frame_id == "base"
        stamp = odometry.header.stamp
        assert before <= stamp.sec * 1_000_000_000 + stamp.nanosec <= after


def test_without_a_simulated_robot_nothing_tells_where_it_is() -> None:
    with opened():
        odom = reader("odom", msg.Odometry)
        assert not odom.get_matched_publications()


def test_what_is_obeyed_is_published_in_lower_case_and_nothing_else() -> None:
    events: list[Event] = [
        said("go back"),
        said("go back", accepted=False),
        said("stop", source=ROS2_SOURCE),
        Partial(0.0, "stop", 0.5),
        Reply(0.0, "bep bep"),
        Notice(0.0, "no loudspeaker"),
        said("Point BEER"),
    ]
    with opened() as (robot, _):
        others = reader("recognizer/output", msg.String)
        for event in events:
            robot.receive(event)
    assert [message.data for message in heard(others)] == ["go back", "point beer"]


def test_names_can_be_others_and_stand_in_a_namespace() -> None:
    settings = Ros2(wait=0, namespace="/robot1", cmd_vel="wheels/vel", output="/ears")
    with opened(settings) as (robot, _):
        base = reader("/robot1/wheels/vel", msg.TwistMessage)
        arm = reader("/robot1/selected_object", msg.Int16)
        others = reader("/ears", msg.String)
        for event in (Twist(0.0, 0.1, 0.0), SelectedObject(0.0, 1), said("stop")):
            robot.receive(event)
    assert [len(heard(one)) for one in (base, arm, others)] == [1, 1, 1]


def test_the_domain_of_the_settings_is_another_one(domain: int) -> None:
    with opened(Ros2(wait=0, domain=domain + 100)) as (robot, _):
        here, there = (reader("cmd_vel", msg.TwistMessage, domain=d) for d in (None, domain + 100))
        robot.receive(Twist(0.0, 0.1, 0.0))
        assert [len(heard(here)), len(heard(there))] == [0, 1]


def test_diagnostics_come_once_a_second_and_tell_how_it_is() -> None:
    with opened() as (robot, _):
        monitor = reader("/diagnostics", msg.DiagnosticArray)
        base = reader("cmd_vel", msg.TwistMessage)
        robot.receive(said("go forward"))
        robot.receive(said("go", accepted=False))
        for cycle in range(31):
            if cycle == 15:
                robot.receive(Notice(1.5, "the microphone is gone"))
                robot.receive(Notice(1.6, "listening again", good=True))
            robot.receive(Twist(cycle / 10, 0.1, 0.0))
        robot.receive(Twist(20.0, 0.1, 0.0))
        del base
        robot.receive(Twist(21.0, 0.1, 0.0))
    statuses = [message.status[0] for message in heard(monitor)]
    forward = "robot drives forward at 0.10 m/s"
    assert [(status.level, status.message) for status in statuses] == [
        (0, forward),
        (0, forward),
        (1, "the microphone is gone"),
        (1, "the microphone is gone"),
        (0, forward),
        (1, "nobody listens to /cmd_vel"),
    ]
    values = {value.key: value.value for value in statuses[0].values}
    assert values["last heard"] == "go"
    assert (values["obeyed"], values["refused"]) == ("1", "1")


def test_it_waits_for_somebody_to_listen() -> None:
    bases: list[Any] = []
    later = Timer(0.3, lambda: bases.append(reader("cmd_vel", msg.TwistMessage)))
    later.start()
    with opened(Ros2(wait=30)) as (robot, told):
        assert robot.lost() is None
    later.join()
    assert [warning.text for warning in told] == [f"{SOMEBODY} listens to /cmd_vel"]


def test_it_tells_that_nobody_listens_and_says_who_comes_and_goes() -> None:
    with opened() as (robot, told):
        assert robot.lost() == "nobody listens to /cmd_vel"
        base = reader("cmd_vel", msg.TwistMessage)
        assert robot.lost() is None
        robot.receive(Twist(1.5, 0.0, 0.0))
        del base
        assert robot.lost() == "nobody listens to /cmd_vel"
        robot.receive(Twist(1.6, 0.0, 0.0))
    assert told == [
        Notice(1.5, f"{SOMEBODY} listens to /cmd_vel", good=True),
        Notice(1.6, f"{SOMEBODY} left /cmd_vel"),
    ]


def test_who_else_sends_velocities_is_told_of_when_it_comes_and_when_it_goes() -> None:
    before = VelocityTopic(Ros2Node(NOW), NOW)
    with opened() as (robot, told):
        del before
        robot.receive(Twist(1.5, 0.0, 0.0))
        other = VelocityTopic(Ros2Node(NOW), NOW)
        robot.receive(Twist(1.6, 0.0, 0.0))
        robot.receive(Twist(1.7, 0.0, 0.0))
        del other
    too = f"{SOMEBODY} sends velocities on /cmd_vel too: {ONE_SENDER}"
    assert told == [
        Notice(0.0, too),
        Notice(1.5, f"{SOMEBODY} left /cmd_vel", good=True),
        Notice(1.6, too),
    ]


def test_who_sends_no_velocity_to_the_same_base_is_not_told_of() -> None:
    with opened() as (robot, told):
        watchdog = Ros2Watchdog(RobotSpec("ros2", Config(ros2=NOW), only_zero=True))
        watchdog.open()
        others = [
            VelocityTopic(Ros2Node(NOW), NOW, only_zero=True),
            VelocityTopic(Ros2Node(NOW), Ros2(stamped=True)),
            VelocityTopic(Ros2Node(NOW), Ros2(cmd_vel="teleop/cmd_vel")),
        ]
        robot.receive(Twist(1.5, 0.0, 0.0))
        watchdog.close()
        del others
    assert told == []


def test_a_listener_that_wants_the_other_type_is_told_of() -> None:
    with opened() as (robot, _):
        base = reader("cmd_vel", msg.TwistStamped)
        robot.receive(Twist(0.0, 0.0, 0.0))
        assert robot.lost() == (
            "a listener to /cmd_vel wants geometry_msgs/msg/TwistStamped, "
            "not geometry_msgs/msg/Twist: see `stamped` in voz.toml"
        )
        del base
        robot.receive(Twist(1.0, 0.0, 0.0))
        assert robot.lost() == "nobody listens to /cmd_vel"


def test_a_listener_that_asks_for_too_much_is_told_of() -> None:
    with opened() as (robot, _):
        base = reader("cmd_vel", msg.TwistMessage, Policy.Deadline(100_000_000))
        robot.receive(Twist(0.0, 0.0, 0.0))
        assert "quality of service that is not offered" in (robot.lost() or "")
        del base


@pytest.mark.slow
def test_a_listener_that_hangs_is_lost_until_it_answers_again(own: Callable[..., Program]) -> None:
    with opened() as (robot, _):
        base = own("cyclone_peer.py")
        drive_until(robot, lambda: robot.lost() is None)
        base.process.send_signal(signal.SIGSTOP)
        drive_until(robot, robot.lost)
        assert (robot.lost() or "").endswith("does not acknowledge /cmd_vel")
        base.process.send_signal(signal.SIGCONT)
        drive_until(robot, lambda: robot.lost() is None)


def drive_until(robot: Ros2Robot, true: Callable[[], object]) -> None:
    """Send velocities until it is true."""
    begun = time.monotonic()

    def send() -> object:
        robot.receive(Twist(time.monotonic() - begun, 0.0, 0.0))
        time.sleep(0.1)  # the beat that a robot is driven in
        return true()

    wait_until(send)


@pytest.mark.parametrize(
    ("name", "said", "told"),
    [
        ("ROS_STATIC_PEERS", "127.0.0.1;no-such-robot.invalid", "no-such-robot.invalid: unknown"),
        ("ROS_STATIC_PEERS", "[::1]:7400", "[::1]:7400"),
        ("ROS_STATIC_PEERS", "a b", "a b: unknown address"),
        ("CYCLONEDDS_URI", "<CycloneDDS><Domain><Nonsense/></Domain></CycloneDDS>", "Nonsense"),
        ("CYCLONEDDS_URI", "<", "parser error"),
        ("CYCLONEDDS_URI", "file:///none.xml", "can't open configuration file"),
    ],
)
def test_what_cyclone_cannot_use_is_one_line(
    name: str,
    said: str,
    told: str,
    monkeypatch: pytest.MonkeyPatch,
    capfd: pytest.CaptureFixture[str],
) -> None:
    monkeypatch.setenv(name, said)
    with pytest.raises(ConfigError, match=f"^{name} cannot be used .*; correct it$") as raised:
        Ros2Robot(NOW).open()
    assert told in str(raised.value)
    assert capfd.readouterr() == ("", "")


def test_peers_that_are_known_are_no_matter(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("ROS_STATIC_PEERS", "127.0.0.1:7400;localhost")
    robot = Ros2Robot(NOW)
    robot.open()
    robot.close()


def test_an_environment_that_cannot_be_is_refused(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("ROS_DOMAIN_ID", "a")
    with pytest.raises(ConfigError, match="ROS_DOMAIN_ID"):
        Ros2Robot(NOW).open()


def test_a_loopback_that_the_user_names_too_is_taken_once(monkeypatch: pytest.MonkeyPatch) -> None:
    place = '<General><Interfaces><NetworkInterface name="lo"/></Interfaces></General>'
    uri = f"<CycloneDDS><Domain>{place}</Domain></CycloneDDS>"
    monkeypatch.setenv("CYCLONEDDS_URI", uri)  # ROS_AUTOMATIC_DISCOVERY_RANGE is LOCALHOST
    with opened() as (robot, _):
        robot.receive(Twist(0.0, 0.1, 0.0))


def test_without_cyclonedds_one_line_says_what_to_install() -> None:
    program = (
        "import sys\n"
        "from voz.errors import RobotError\n"
        "sys.modules['cyclonedds'] = None\n"
        "try:\n"
        "    import voz.ros2\n"
        "except RobotError as error:\n"
        "    print(error)\n"
    )
    done = subprocess.run(
        [sys.executable, "-c", program], capture_output=True, text=True, check=True
    )
    assert done.stdout.endswith(f"; {how_to_install('ros2')}\n")
    assert done.stdout.count("\n") == 1


def test_it_knows_where_the_base_says_that_it_is(domain: int) -> None:
    robot, base = Ros2Robot(Ros2(wait=0)), Ros2Robot(Ros2(wait=0))
    base.where = lambda t: WorldState(t, Pose2D(1 / 3, -0.5, 3.0), 0.1, -0.2)
    robot.open()
    base.open()
    assert robot.place(0) is None

    def told() -> object:
        base.receive(Twist(0, 0, 0))
        return robot.place(0)

    wait_until(told)
    assert robot.place(0) == pytest.approx((1 / 3, -0.5, 3.0))
    base.close()
    wait_until(lambda: robot.place(0) is None)
    robot.close()


CANCELING = Ros2(wait=0, cancel=("navigate_to_pose",))
SERVICE = "navigate_to_pose/_action/cancel_goal"
ALL_GOALS = {"goal": [0] * 16, "stamp": [0, 0]}

SERVERS = [(Path(sys.executable), "cyclone_server.py")]
if ORDINARY:  # the wheels of rclpy are for this processor alone
    SERVERS.append((RCLPY, "cancel_server.py"))


def utterance(text: str, obeyed: bool = True) -> Utterance:
    return Utterance(0.0, text, 0.9, True, 0.0, 0.0, "microphone", obeyed=obeyed)


@pytest.mark.parametrize("server", SERVERS, ids=lambda server: server[1])
def test_either_ros_2_is_asked_to_cancel_all_goals(
    server: tuple[Path, str], programs: Callable[..., Program]
) -> None:
    asked = programs(*server, service=SERVICE)
    asked.wait_for(lambda line: line.get("ready"))
    robot = Ros2Robot(CANCELING)
    robot.open()
    wait_for_servers(robot)
    for text in ("stop", "stop speech"):
        robot.receive(utterance(text))
        assert asked.wait_for(lambda line: "goal" in line) == [ALL_GOALS]
    robot.close()
    assert asked.wait_for(lambda line: "goal" in line) == [ALL_GOALS]


@pytest.mark.slow
def test_a_server_of_another_kind_may_take_the_place_of_one(
    programs: Callable[..., Program],
) -> None:
    robot = Ros2Robot(CANCELING)
    robot.open()
    for server in SERVERS:
        asked = programs(*server, service=SERVICE)
        asked.wait_for(lambda line: line.get("ready"))

        def cancels(asked: Program = asked) -> object:  # not by what the one before understood
            robot.receive(Twist(0.0, 0.0, 0.0))
            robot.receive(utterance("stop"))
            return not asked.is_silent

        wait_until(cancels)
        assert asked.wait_for(lambda line: "goal" in line) == [ALL_GOALS]
        asked.end(15)
    robot.close()


def test_only_what_stops_the_robot_cancels() -> None:
    asked = serve(CANCELING)
    robot = Ros2Robot(CANCELING)
    robot.open()
    wait_for_servers(robot)
    for event in (
        utterance("go forward"),
        utterance("stop", obeyed=False),
        Partial(0.0, "stop", 0.5),
        Twist(0.0, 0.0, 0.0),
        Notice(0.0, "no loudspeaker"),
        Notice(0.0, "listening again", good=True),
    ):
        robot.receive(event)
    assert requests(asked) == []
    robot.receive(Notice(0.0, "the microphone is gone: the robot stops", stops=True))
    assert len(requests(asked)) == 1
    robot.close()
    assert len(requests(asked)) == 1


def test_names_stand_in_the_namespace_and_the_list_may_be_empty() -> None:
    settings = Ros2(wait=0, namespace="robot1", cancel=("navigate_to_pose", "/dock"))
    there = [serve(settings, name) for name in settings.cancel]
    assert there[0].topic.name == "rq/robot1/navigate_to_pose/_action/cancel_goalRequest"
    robot = Ros2Robot(settings)
    robot.open()
    wait_for_servers(robot, 2)
    robot.receive(utterance("stop"))
    assert [len(requests(one)) for one in there] == [1, 1]
    robot.close()
    assert [len(requests(one)) for one in there] == [1, 1]
    without = Ros2Robot(Ros2(wait=0, namespace="robot1", cancel=()))
    without.open()
    without.receive(utterance("stop"))
    without.close()
    assert [len(requests(one)) for one in there] == [0, 0]


def serve(settings: Ros2, action: str = "navigate_to_pose") -> DataReader[Any]:
    """Read what is asked of an action's server on Cyclone."""
    node = Ros2Node(settings)
    name = node.request_topic(f"{action}/_action/cancel_goal")
    topic = Topic(node.participant, name, CycloneCancelAllGoals)
    return DataReader(node.participant, topic, node.qos(CycloneCancelAllGoals))


def requests(reader: DataReader[Any]) -> list[Any]:
    return [one for one in reader.take(100) if isinstance(one, IdlStruct)]


def wait_for_servers(robot: Ros2Robot, number: int = 1) -> None:
    """Let the robot find so many servers."""

    def found() -> bool:
        robot.receive(Twist(0.0, 0.0, 0.0))
        ready = [writer for writer in robot.writers if writer.topic.name.startswith("rq/")]
        return len(ready) == number and all(w.get_matched_subscriptions() for w in ready)

    wait_until(found)
