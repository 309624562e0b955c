"""A test by the clock is tried again when it fails, and only where the machine had no time."""

from __future__ import annotations

from pathlib import Path

import keeping_up
import pytest

pytest_plugins = "pytester"

FAILS_TWICE = """
import pytest
tries = []

@pytest.fixture
def pulse():
    return None

@pytest.fixture
def sound(pulse):
    return pulse

@pytest.fixture
def made():
    tries.append(len(tries))

{mark}
def test_it(made):
    assert len(tries) > {failures}
"""

BY_SOUND = '@pytest.mark.usefixtures("sound")'


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
    _, told, why = result.stdout.str().partition(keeping_up.AGAIN)
    assert not told or "assert 1 > " in why  # what the first try failed of
    (ended,) = result.parseoutcomes()
    return f"{ended}{', tried again' if told else ''}"


@pytest.mark.parametrize("late", [("CROWDED", -1.0), ("STALL", -1.0)])
def test_on_a_machine_that_has_no_time_what_goes_by_the_clock_has_three_tries(
    late: tuple[str, float], pytester: pytest.Pytester, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(keeping_up, *late)
    assert outcome(pytester, failures=0) == "passed"
    assert outcome(pytester, failures=2) == "passed, tried again"
    assert outcome(pytester, failures=3) == "failed, tried again"
    assert outcome(pytester, failures=2, mark=BY_SOUND) == "passed, tried again"
    assert outcome(pytester, failures=1, mark="") == "failed"


def test_on_a_machine_that_has_the_first_failure_counts(
    pytester: pytest.Pytester, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(keeping_up, "CROWDED", 1000.0)
    monkeypatch.setattr(keeping_up, "STALL", 1000.0)
    assert outcome(pytester, failures=1) == "failed"
    assert outcome(pytester, failures=0) == "passed"
