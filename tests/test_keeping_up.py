"""A test is tried again only where the machine stood still."""

from __future__ import annotations

import time

import keeping_up
import pytest
from keeping_up import STALL, TRIES, where_the_machine_keeps_up


def test_a_failure_on_a_machine_that_stood_still_is_tried_again(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    tries = []

    @where_the_machine_keeps_up
    def fails_twice() -> None:
        tries.append(time.monotonic())
        time.sleep(0.05)
        assert len(tries) > 2

    monkeypatch.setattr(keeping_up, "CROWDED", 1000.0)
    monkeypatch.setattr(keeping_up, "STALL", -1.0)
    fails_twice()
    assert len(tries) == 3
    tries.clear()
    monkeypatch.setattr(keeping_up, "STALL", 1000.0)
    with pytest.raises(AssertionError):
        fails_twice()
    assert len(tries) == 1
    tries.clear()
    monkeypatch.setattr(keeping_up, "CROWDED", -1.0)
    fails_twice()
    assert len(tries) == 3
    assert 0 < STALL < 0.1 < TRIES
