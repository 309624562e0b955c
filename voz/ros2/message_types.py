"""The ROS 2 messages that voz sends and reads, as DDS types: field by field those of ROS.

No `from __future__ import annotations` here: cyclonedds looks the written types up in this module.
"""

import time
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Annotated, Any

from cyclonedds.idl import IdlStruct
from cyclonedds.idl.annotations import final
from cyclonedds.idl.types import (
    array,
    float64,
    int16,
    int32,
    int64,
    sequence,
    uint8,
    uint32,
    uint64,
)

EXACT = (0.0,) * 36
"""The covariance of what is not uncertain at all."""


@dataclass
@final
class Time(IdlStruct, typename="builtin_interfaces::msg::dds_::Time_"):
    """Seconds and nanoseconds since 1970."""

    sec: int32
    nanosec: uint32


@dataclass
@final
class HeaderMessage(IdlStruct, typename="std_msgs::msg::dds_::Header_"):
    """When, and in which coordinate frame."""

    stamp: Time
    frame_id: str


@dataclass
@final
class Int16(IdlStruct, typename="std_msgs::msg::dds_::Int16_"):
    """A number."""

    data: int16


@dataclass
@final
class String(IdlStruct, typename="std_msgs::msg::dds_::String_"):
    """A text."""

    data: str


@dataclass
@final
class Bool(IdlStruct, typename="std_msgs::msg::dds_::Bool_"):
    """Yes or no."""

    data: bool


@dataclass
@final
class Int32(IdlStruct, typename="std_msgs::msg::dds_::Int32_"):
    """A whole number."""

    data: int32


@dataclass
@final
class Float64(IdlStruct, typename="std_msgs::msg::dds_::Float64_"):
    """A number."""

    data: float64


MESSAGE_TYPES: dict[type, Any] = {bool: Bool, int: Int32, float: Float64, str: String}
"""What holds a value of a type in ROS."""


@dataclass
@final
class Vector3(IdlStruct, typename="geometry_msgs::msg::dds_::Vector3_"):
    """Along or around the three axes; m/s or rad/s."""

    x: float64 = 0.0
    y: float64 = 0.0
    z: float64 = 0.0


@dataclass
@final
class TwistMessage(IdlStruct, typename="geometry_msgs::msg::dds_::Twist_"):
    """A velocity: `geometry_msgs/Twist`, which voz sends where an event is a `Twist`."""

    linear: Vector3
    angular: Vector3


@dataclass
@final
class TwistStamped(IdlStruct, typename="geometry_msgs::msg::dds_::TwistStamped_"):
    """A velocity with its time."""

    header: HeaderMessage
    twist: TwistMessage


@dataclass
@final
class TwistWithCovariance(IdlStruct, typename="geometry_msgs::msg::dds_::TwistWithCovariance_"):
    """A velocity and its uncertainty."""

    twist: TwistMessage
    covariance: Annotated[Sequence[float], array(float64, 36)] = EXACT


@dataclass
@final
class Point(IdlStruct, typename="geometry_msgs::msg::dds_::Point_"):
    """A place, m."""

    x: float64 = 0.0
    y: float64 = 0.0
    z: float64 = 0.0


@dataclass
@final
class Quaternion(IdlStruct, typename="geometry_msgs::msg::dds_::Quaternion_"):
    """An orientation."""

    x: float64 = 0.0
    y: float64 = 0.0
    z: float64 = 0.0
    w: float64 = 1.0


@dataclass
@final
class Pose(IdlStruct, typename="geometry_msgs::msg::dds_::Pose_"):
    """A place and an orientation."""

    position: Point
    orientation: Quaternion


@dataclass
@final
class PoseWithCovariance(IdlStruct, typename="geometry_msgs::msg::dds_::PoseWithCovariance_"):
    """A pose and its uncertainty."""

    pose: Pose
    covariance: Annotated[Sequence[float], array(float64, 36)] = EXACT


@dataclass
@final
class Odometry(IdlStruct, typename="nav_msgs::msg::dds_::Odometry_"):
    """The pose of a base in the frame of the header, and its velocity in its own frame."""

    header: HeaderMessage
    child_frame_id: str
    pose: PoseWithCovariance
    twist: TwistWithCovariance


@dataclass
@final
class Transform(IdlStruct, typename="geometry_msgs::msg::dds_::Transform_"):
    """The transform from one frame to another."""

    translation: Vector3
    rotation: Quaternion


@dataclass
@final
class TransformStamped(IdlStruct, typename="geometry_msgs::msg::dds_::TransformStamped_"):
    """The pose of a frame in that of the header, at a time."""

    header: HeaderMessage
    child_frame_id: str
    transform: Transform


@dataclass
@final
class TFMessage(IdlStruct, typename="tf2_msgs::msg::dds_::TFMessage_"):
    """Transforms of several frames."""

    transforms: Annotated[Sequence[TransformStamped], sequence(TransformStamped)]


@dataclass
@final
class KeyValue(IdlStruct, typename="diagnostic_msgs::msg::dds_::KeyValue_"):
    """A figure and its name."""

    key: str
    value: str


@dataclass
@final
class DiagnosticStatus(IdlStruct, typename="diagnostic_msgs::msg::dds_::DiagnosticStatus_"):
    """The status of a part; level 0 is well, 1 a warning, 2 an error."""

    level: uint8
    name: str
    message: str
    hardware_id: str
    values: Annotated[Sequence[KeyValue], sequence(KeyValue)]


@dataclass
@final
class DiagnosticArray(IdlStruct, typename="diagnostic_msgs::msg::dds_::DiagnosticArray_"):
    """The status of several parts at a time."""

    header: HeaderMessage
    status: Annotated[Sequence[DiagnosticStatus], sequence(DiagnosticStatus)]


@dataclass
@final
class CancelAllGoals(IdlStruct, typename="action_msgs::srv::dds_::CancelGoal_Request_"):
    """A request to an action's `cancel_goal`; without a goal and a time it means all goals."""

    goal: Annotated[Sequence[int], array(uint8, 16)] = (0,) * 16
    sec: int32 = 0
    nanosec: uint32 = 0


@dataclass
@final
class CycloneCancelAllGoals(IdlStruct, typename="action_msgs::srv::dds_::CancelGoal_Request_"):
    """The same for ROS 2 on Cyclone: it begins with the asker; 0 gets no answer."""

    asker: uint64 = 0
    number: int64 = 0
    goal: Annotated[Sequence[int], array(uint8, 16)] = (0,) * 16
    sec: int32 = 0
    nanosec: uint32 = 0


def header(frame_id: str) -> HeaderMessage:
    """Return a header with the time of day, in a coordinate frame if one matters."""
    seconds, nanoseconds = divmod(time.time_ns(), 1_000_000_000)
    return HeaderMessage(Time(seconds, nanoseconds), frame_id)


def velocity(linear: float, angular: float) -> TwistMessage:
    """Return a velocity: forward, m/s, and turning to the left, rad/s."""
    return TwistMessage(Vector3(x=linear), Vector3(z=angular))


def stamped(twist: TwistMessage, frame_id: str) -> TwistStamped:
    """Add the time of day and the frame of the base to a velocity."""
    return TwistStamped(header(frame_id), twist)


CANCEL_GOAL = "RIHS01_3d3c84653c1f96918086887e1dcb236faec88b81a5b14fd4cf4840065bcdf8af"

TYPE_HASHES: dict[type[Any], str] = {
    Int16: "RIHS01_1dcc3464e47c288a55f943a389d337cdb06804de3f5cd7a266b0de718eee17e5",
    String: "RIHS01_df668c740482bbd48fb39d76a70dfd4bd59db1288021743503259e948f6b1a18",
    Bool: "RIHS01_feb91e995ff9ebd09c0cb3d2aed18b11077585839fb5db80193b62d74528f6c9",
    Int32: "RIHS01_b6578ded3c58c626cfe8d1a6fb6e04f706f97e9f03d2727c9ff4e74b1cef0deb",
    Float64: "RIHS01_705ba9c3d1a09df43737eb67095534de36fd426c0587779bda2bc51fe790182a",
    TwistMessage: "RIHS01_9c45bf16fe0983d80e3cfe750d6835843d265a9a6c46bd2e609fcddde6fb8d2a",
    TwistStamped: "RIHS01_5f0fcd4f81d5d06ad9b4c4c63e3ea51b82d6ae4d0558f1d475229b1121db6f64",
    Odometry: "RIHS01_3cc97dc7fb7502f8714462c526d369e35b603cfc34d946e3f2eda2766dfec6e0",
    TFMessage: "RIHS01_e369d0f05a23ae52508854b66f6aa0437f3449d652e8cbf22d5abe85d020f087",
    CancelAllGoals: CANCEL_GOAL,
    CycloneCancelAllGoals: CANCEL_GOAL,
    DiagnosticArray: "RIHS01_5a8a36efb05fb25070fa0fb3810290c0e6cd4862b54a8fb975a1ee8dc55a333e",
}
"""By these a ROS since Iron knows that its definition is the same; the packages' JSON has them."""
