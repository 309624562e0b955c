"""ROS 2 with no ROS installed, by the package cyclonedds (`make ros2`)."""

from voz.errors import RobotError
from voz.extras import how_to_install

try:
    import cyclonedds  # noqa: F401
except ImportError as error:
    raise RobotError(f"ROS 2 needs cyclonedds ({error}); {how_to_install('ros2')}") from error

from voz.ros2.other_recognizer import HEARD_ON_ROS, heard_on_ros
from voz.ros2.robot import Ros2Robot

__all__ = ["HEARD_ON_ROS", "Ros2Robot", "heard_on_ros"]
