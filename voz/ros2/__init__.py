"""ROS 2 with no ROS installed, by the package cyclonedds (`make ros2`)."""

from voz.errors import RobotError
from voz.extras import how_to_install

try:
    import cyclonedds  # noqa: F401
except ImportError as error:
    raise RobotError(f"ROS 2 needs cyclonedds ({error}); {how_to_install('ros2')}") from error

from voz.ros2.other_recognizer import ROS2_SOURCE, listen_to_recognizer
from voz.ros2.robot import Ros2Robot

__all__ = ["ROS2_SOURCE", "Ros2Robot", "listen_to_recognizer"]
