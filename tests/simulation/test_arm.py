from __future__ import annotations

from math import dist, hypot, pi

import pytest
from hypothesis import assume, given
from hypothesis import strategies as st

from voz.simulation.arm import (
    FOLDED,
    LINK_LENGTH,
    SHOULDER_HEIGHT,
    Joints,
    arm_points,
    joints_pointing_at,
    turn_joints,
)
from voz.simulation.kinematics import Pose2D, wrap_angle

poses = st.builds(Pose2D, st.floats(0, 5), st.floats(0, 5), st.floats(-pi, pi))
places = st.tuples(st.floats(0, 5), st.floats(0, 5), st.floats(0, 2))
angles = st.floats(-pi, pi - 1e-6)
joints = st.builds(Joints, angles, angles, angles)


@given(poses, places)
def test_the_line_from_shoulder_to_hand_goes_through_the_target(
    pose: Pose2D, target: tuple[float, float, float]
) -> None:
    shoulder, elbow, hand = arm_points(pose, joints_pointing_at(pose, target))
    away = dist(shoulder, target)
    assume(away > 0.01)
    along = tuple(
        s + (h - s) * away / (2 * LINK_LENGTH) for s, h in zip(shoulder, hand, strict=True)
    )
    assert dist(along, target) < 1e-9
    assert dist(elbow, [(s + h) / 2 for s, h in zip(shoulder, hand, strict=True)]) < 1e-9


@given(poses, joints)
def test_the_links_keep_their_length_and_the_shoulder_its_place(pose: Pose2D, arm: Joints) -> None:
    shoulder, elbow, hand = arm_points(pose, arm)
    assert shoulder == (pose.x, pose.y, SHOULDER_HEIGHT)
    assert dist(shoulder, elbow) == pytest.approx(LINK_LENGTH)
    assert dist(elbow, hand) == pytest.approx(LINK_LENGTH)


def test_what_is_to_the_left_and_above_needs_a_pan_to_the_left_and_a_tilt_up() -> None:
    arm = joints_pointing_at(Pose2D(1.0, 1.0, 0.0), (1.0, 2.0, SHOULDER_HEIGHT + 1.0))
    assert arm == pytest.approx((pi / 2, pi / 4, 0.0))
    assert joints_pointing_at(
        Pose2D(1.0, 1.0, pi / 2), (1.0, 2.0, SHOULDER_HEIGHT)
    ).pan == pytest.approx(0)


@given(poses)
def test_a_folded_arm_is_above_its_base(pose: Pose2D) -> None:
    for x, y, height in arm_points(pose, FOLDED):
        assert hypot(x - pose.x, y - pose.y) < 0.17
        assert height >= SHOULDER_HEIGHT


@given(joints, joints, st.floats(0.001, 1))
def test_no_joint_turns_faster_than_its_limit(arm: Joints, wanted: Joints, most: float) -> None:
    after = turn_joints(arm, wanted, most)
    angles = [wrap_angle(after.pan - arm.pan), after.tilt - arm.tilt, after.elbow - arm.elbow]
    assert all(abs(angle) <= most + 1e-12 for angle in angles)


@given(joints, joints)
def test_an_arm_arrives_and_stays(arm: Joints, wanted: Joints) -> None:
    for _ in range(80):
        arm = turn_joints(arm, wanted, 0.1)
    assert arm == pytest.approx(wanted)
    assert turn_joints(arm, wanted, 0.1) == arm


def test_the_pan_goes_the_short_way_round() -> None:
    after = turn_joints(Joints(3.0, 0.0, 0.0), Joints(-3.0, 0.0, 0.0), 0.1)
    assert after.pan == pytest.approx(3.1)
