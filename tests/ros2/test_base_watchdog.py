"""The example for bases that drive on when no velocity comes any more, run by the real rclpy."""

from __future__ import annotations

import shlex
import signal
import time
from collections.abc import Callable
from contextlib import ExitStack
from pathlib import Path

import pytest
from calls import VOZ
from cyclonedds.pub import DataWriter
from documents import recipe
from programs import Program, wait_until
from recordings import ROOT
from ros2.conftest import RCLPY

from voz.ros2.message_types import TwistMessage, TwistStamped, Vector3
from voz.ros2.node import Ros2Node
from voz.settings import Ros2

pytestmark = pytest.mark.slow


class Base:
    """A base behind the watchdog, and who drives it."""

    def __init__(self) -> None:
        node = Ros2Node(Ros2())
        self.driver: DataWriter[TwistMessage] = node.writer("cmd_vel", TwistMessage)
        self.wheels = node.reader("base_cmd_vel", TwistMessage)

    def drive(self, linear: float) -> None:
        """Send a velocity again and again until it arrives."""

        def arrives() -> bool:
            self.driver.write(TwistMessage(Vector3(x=linear), Vector3()))
            time.sleep(0.05)
            return linear in self.heard()

        wait_until(arrives)

    def stands(self) -> None:
        wait_until(lambda: self.heard()[-1:] == [0.0])

    def heard(self) -> list[float]:
        return [message.linear.x for message in self.wheels.take(100)]


@pytest.fixture
def watchdog(programs: Callable[..., Program]) -> Program:
    return programs(RCLPY, str(ROOT / "examples" / "base_watchdog_ros2.py"))


def test_what_comes_is_passed_on_and_when_nothing_comes_the_base_gets_zero(
    watchdog: Program,
) -> None:
    base = Base()
    for linear in (0.2, -0.1):
        base.drive(linear)
        base.stands()


@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGTERM])
def test_the_last_it_sends_is_zero(number: int, watchdog: Program) -> None:
    base = Base()
    base.drive(0.2)
    watchdog.end(number)
    assert watchdog.process.returncode == 0
    base.stands()


@pytest.mark.parametrize("stamped", [False, True])
def test_the_recipe_of_the_turtlebot_puts_it_between_voz_and_the_base(
    stamped: bool, domain: int, tmp_path: Path
) -> None:
    page = recipe("A TurtleBot with ROS 2")
    (line,) = (line for line in page.blocks("")[1].splitlines() if "watchdog" in line)
    _, script, *names = shlex.split(line)
    names += ["-p", "stamped:=true"] if stamped else []
    settings = page.blocks("toml")[1] + f"stamped = {str(stamped).lower()}\n"
    (tmp_path / "voz.toml").write_text(settings)
    wheels = Ros2Node(Ros2()).reader("cmd_vel", TwistStamped if stamped else TwistMessage)
    options = "run --robot ros2 --text - --events - --listening --no-sound --no-watchdog --config"

    def heard() -> list[float]:
        twists = [message.twist if stamped else message for message in wheels.take(100)]
        return [twist.linear.x for twist in twists]

    with ExitStack() as stack:
        watchdog = Program([str(RCLPY), str(ROOT / "examples" / script), *names])
        stack.callback(watchdog.close)
        robot = Program([*VOZ, *options.split(), str(tmp_path / "voz.toml")])
        stack.callback(robot.close)

        def drives() -> bool:
            robot.say("go forward")
            time.sleep(0.1)
            return 0.1 in heard()

        wait_until(drives)
        robot.end(signal.SIGKILL)
        wait_until(lambda: heard()[-1:] == [0.0])
