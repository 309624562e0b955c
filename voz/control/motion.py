"""How a command changes the velocities, by the rules of the original program. Pure."""

from __future__ import annotations

import enum

import msgspec
from msgspec.structs import replace

from voz.control.steps import PER_UNIT, Step


class Mode(enum.Enum):
    """Whether the last change of direction was a turn in motion or a rotation on the spot."""

    NONE = "none"
    TURNING = "turning"
    ROTATING = "rotating"


class Motion(msgspec.Struct, frozen=True):
    """Velocities: forward, thousandths of 1 m/s, and to the left, thousandths of 1 rad/s."""

    linear: int = 0
    angular: int = 0
    mode: Mode = Mode.NONE

    @property
    def moving(self) -> bool:
        """Whether any velocity is not 0."""
        return bool(self.linear or self.angular)

    def velocities(self) -> tuple[float, float]:
        """The linear (m/s) and angular (rad/s) velocity."""
        return self.linear / PER_UNIT, self.angular / PER_UNIT


def halt(motion: Motion) -> Motion:
    """Both velocities 0; the mode stays."""
    return replace(motion, linear=0, angular=0)


def go(motion: Motion, linear: int) -> Motion:
    """Drive straight at a new linear velocity."""
    return replace(motion, linear=linear, angular=0)


def turn(motion: Motion, angular: int) -> Motion:
    """Turn to the side of `angular` while driving; a turn to that side gets tighter."""
    if motion.angular * angular <= 0 or motion.mode is Mode.ROTATING:
        return replace(motion, angular=angular, mode=Mode.TURNING)
    return replace(motion, angular=motion.angular + angular)


def rotate(motion: Motion, angular: int) -> Motion:
    """Rotate on the spot to the side of `angular`."""
    if motion.angular * angular <= 0 or motion.mode is Mode.TURNING:
        return replace(motion, linear=0, angular=angular, mode=Mode.ROTATING)
    return replace(motion, linear=0)


def faster(motion: Motion, by: int) -> Motion:
    """Move the velocity in use away from 0."""
    if motion.linear:
        return replace(motion, linear=motion.linear + (by if motion.linear > 0 else -by))
    if motion.mode is Mode.ROTATING:
        return replace(motion, angular=motion.angular + (by if motion.angular > 0 else -by))
    return motion


def slower(motion: Motion, by: int) -> Motion:
    """Move the velocity in use toward 0, and past 0 to the other side."""
    return faster(motion, -by)


def apply_step(motion: Motion, step: Step) -> Motion:
    """Apply the velocities of a step whose slots are filled."""
    if step.stop:
        return halt(motion)
    if step.bounded:  # its velocity does not depend on the one before
        motion = replace(motion, angular=0)
    for name, change in CHANGES.items():
        amount = getattr(step, name)
        if amount is not None:
            return change(motion, round(amount * PER_UNIT))
    return motion


CHANGES = {"drive": go, "turn": turn, "rotate": rotate, "faster": faster, "slower": slower}
