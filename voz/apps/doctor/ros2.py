"""ROS 2: whether cyclonedds is there, who listens to `cmd_vel`, whether the base stops. An edge."""

from __future__ import annotations

import time
from collections.abc import Iterator
from contextlib import contextmanager

from voz.apps.doctor.finding import Finding, not_well
from voz.apps.doctor.stopping import Base
from voz.errors import VozError
from voz.settings import Ros2

NAME = "ROS 2"


def ros2(settings: Ros2) -> Iterator[Finding]:
    """Look at ROS 2, for a robot that is driven by it.

    Args:
        settings: the domain, and the topics.
    """
    try:
        import voz.ros2  # noqa: F401, it says what to do where cyclonedds is missing
        from voz.apps.doctor.ros2_base import listeners

        topic, domain, names, obstacle = listeners(settings)
    except VozError as error:
        yield not_well(NAME, error)
        return
    yield Finding(NAME, True, f"domain {domain} is joined")
    what = f"{NAME} {topic}"
    if names:
        yield Finding(what, True, f"{' and '.join(names)} listens")
    else:
        to_do = "start the base's driver, or look at ROS_DOMAIN_ID and at [ros2] in voz.toml"
        yield Finding(what, False, obstacle or "nobody listens", to_do)


@contextmanager
def ros2_base(settings: Ros2, odometry: str) -> Iterator[Base]:
    """Reach the base for the length of a `with` block.

    Args:
        settings: the domain, and the topic of the velocities.
        odometry: the topic on which the base tells how it moves.

    Raises:
        VozError: the domain cannot be joined.
    """
    import voz.ros2  # noqa: F401, as above
    from voz.apps.doctor.ros2_base import Ros2Base

    yield Ros2Base(settings, odometry, time.monotonic)
