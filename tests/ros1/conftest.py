"""Each test of ROS 1 has a master of its own."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

import pytest
from ros1.ros import Ros, running_ros


@pytest.fixture
def ros(tmp_path: Path) -> Iterator[Ros]:
    with running_ros(tmp_path) as ros:
        yield ros


@pytest.fixture
def ros_with_sound(tmp_path: Path, pulse: dict[str, str]) -> Iterator[Ros]:
    """The same where there is a microphone and a loudspeaker."""
    with running_ros(tmp_path, **pulse) as ros:
        yield ros
