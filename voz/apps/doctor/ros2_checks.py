"""ROS 2: whether cyclonedds is there, who listens to `cmd_vel`, whether the base stops. An edge."""

from __future__ import annotations

import time
from collections.abc import Iterator
from contextlib import contextmanager

from voz.apps.doctor.base_stop_check import Base
from voz.apps.doctor.finding import Finding, failed
from voz.errors import VozError
from voz.settings import Ros2


def check_ros2(settings: Ros2) -> Iterator[Finding]:
    """Check ROS 2, for a robot that is driven by it."""
    try:
        import voz.ros2  # noqa: F401, it says what to do where cyclonedds is missing
        from voz.apps.doctor.ros2_base import check_subscribers

        yield from check_subscribers(settings)
    except VozError as error:
        yield failed("ROS 2", error)


@contextmanager
def open_ros2_base(settings: Ros2, odometry: str) -> Iterator[Base]:
    """Open the base for a `with` block; raises VozError if the domain cannot be joined."""
    import voz.ros2  # noqa: F401, as above
    from voz.apps.doctor.ros2_base import Ros2Base

    yield Ros2Base(settings, odometry, time.monotonic)
