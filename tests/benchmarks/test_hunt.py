"""`benchmarks/hunt.py` as it is called, once on each target."""

from __future__ import annotations

from importlib import import_module
from importlib.util import find_spec

import pytest
from benchmark_programs import printed
from recordings import ROOT

# Seeds whose runs are short, and of many kinds.
RUNS = [("live", 2), ("robot", 11), ("text", 2), ("ros1", 2)]
if find_spec("cyclonedds"):
    RUNS.append(("ros2", 2))


@pytest.mark.realtime
@pytest.mark.slow
@pytest.mark.parametrize(("target", "seed"), RUNS)
def test_a_run_drives_a_robot_and_finds_no_way_to_let_it_drive_on(target: str, seed: int) -> None:
    lines = printed("hunt", "--runs", 1, "--target", target, "--seed", seed, "--verbose")
    assert "1 runs, 0 finds" in "\n".join(lines)


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
def test_a_hunter_sees_who_drives_on(
    velocities: list[tuple[float, float]], wrong: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.syspath_prepend(ROOT / "benchmarks")
    observing = import_module("hunting.observing")
    seen = [observing.Seen("Base", at, linear, 0.0) for at, linear in velocities]
    assert observing.judge(seen, since=10.0, bound=0.5).wrong == wrong
