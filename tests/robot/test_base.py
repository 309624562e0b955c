"""What a robot gets that says only what it does with commands and velocities."""

from __future__ import annotations

from collections.abc import Mapping

from msgspec.structs import replace

from voz.events import Twist, Utterance
from voz.robot.base import Robot

HEARD = Utterance(0, "bring me the cup", 0.9, True, 0, 1, "text")


class Arm(Robot):
    def __init__(self) -> None:
        self.done: list[object] = []

    def move(self, linear: float, angular: float) -> None:
        self.done.append((linear, angular))

    def command(self, name: str, slots: Mapping[str, str | float]) -> None:
        self.done.append((name, dict(slots)))


def test_a_command_is_told_when_and_only_when_it_is_obeyed() -> None:
    arm = Arm()
    for obeyed in (None, False, True):
        arm.receive(replace(HEARD, obeyed=obeyed))
    arm.receive(Twist(0, 0.1, -0.2))
    arm.receive(replace(HEARD, obeyed=True, command="bring", slots={"thing": "cup"}))
    assert arm.done == [("bring me the cup", {}), (0.1, -0.2), ("bring", {"thing": "cup"})]


def test_a_robot_that_does_neither_takes_everything() -> None:
    robot = Robot()
    robot.receive(HEARD)
    robot.receive(replace(HEARD, obeyed=True))
    robot.receive(Twist(0, 0.1, 0))
