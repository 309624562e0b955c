"""A short hunt for a way to let the robot drive on; `benchmarks/hunt.py` is the long one."""

from __future__ import annotations

from importlib.util import find_spec

import pytest
from hunting.observing import Seen, judge
from hunting.run import hunt

# Seeds whose runs are short, and of many kinds.
RUNS = [("live", 2), ("live", 7), ("robot", 11), ("text", 2), ("ros1", 2)]
if find_spec("cyclonedds"):
    RUNS.append(("ros2", 2))


@pytest.mark.realtime
@pytest.mark.slow
@pytest.mark.parametrize(("target", "seed"), RUNS)
def test_whatever_happens_the_robot_stands_still_in_time(target: str, seed: int) -> None:
    done = hunt(target, seed)
    assert not done.finds, str(done)


@pytest.mark.parametrize(
    ("velocities", "wrong"),
    [
        ([], ""),
        ([(9.9, 0.0)], ""),
        ([(9.9, 0.1), (10.4, 0.0)], ""),
        ([(9.9, 0.1), (10.1, 0.0), (10.2, 0.1), (10.4, 0.0)], ""),
        ([(9.9, 0.1), (10.6, 0.0)], "Base gets zero only 0.60 s later"),
        ([(9.9, 0.1)], "Base gets zero never"),
        ([(9.9, 0.1), (10.1, 0.0), (10.7, 0.1), (10.8, 0)], "Base is asked to move 0.70 s later"),
    ],
)
def test_a_hunter_sees_who_drives_on(velocities: list[tuple[float, float]], wrong: str) -> None:
    seen = [Seen("Base", at, linear, 0.0) for at, linear in velocities]
    assert judge(seen, since=10.0, bound=0.5).wrong == wrong
