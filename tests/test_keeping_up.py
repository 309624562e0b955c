"""A slow test that fails is tried again, and only where the machine had no time for it."""

from __future__ import annotations

from pathlib import Path

import keeping_up
import pytest

pytest_plugins = "pytester"

FAILS_TWICE = """
import pytest
tries = []

@pytest.fixture
def made():
    tries.append(len(tries))

{mark}
def test_it(made):
    assert len(tries) > {failures}
"""


@pytest.fixture(autouse=True)
def of_its_own(pytester: pytest.Pytester) -> None:
    """A folder with the hooks of these tests."""
    pytester.makeconftest("from keeping_up import pytest_runtest_protocol, pytest_terminal_summary")
    pytester.makeini("[pytest]\nmarkers = slow: slow")
    pytester.syspathinsert(Path(keeping_up.__file__).parent)


def outcome(pytester: pytest.Pytester, failures: int, mark: str = "@pytest.mark.slow") -> str:
    """Run a test that fails so often, and tell how it ended and whether it was tried again."""
    pytester.makepyfile(FAILS_TWICE.format(mark=mark, failures=failures))
    result = pytester.runpytest_inprocess("-p", "no:cacheprovider")
    told = keeping_up.AGAIN in result.stdout.str()
    (ended,) = result.parseoutcomes()
    return f"{ended}{', tried again' * told}"


@pytest.mark.parametrize("late", [("CROWDED", -1.0), ("STALL", -1.0)])
def test_on_a_machine_that_has_no_time_a_slow_test_has_three_tries(
    late: tuple[str, float], pytester: pytest.Pytester, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(keeping_up, *late)
    assert outcome(pytester, failures=0) == "passed"
    assert outcome(pytester, failures=2) == "passed, tried again"
    assert outcome(pytester, failures=3) == "failed, tried again"
    assert outcome(pytester, failures=1, mark="") == "failed"


def test_on_a_machine_that_has_the_first_failure_counts(
    pytester: pytest.Pytester, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(keeping_up, "CROWDED", 1000.0)
    monkeypatch.setattr(keeping_up, "STALL", 1000.0)
    assert outcome(pytester, failures=1) == "failed"
    assert outcome(pytester, failures=0) == "passed"
