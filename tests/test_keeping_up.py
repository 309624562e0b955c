"""A test is tried again when it fails, and only where the machine had no time for it."""

from __future__ import annotations

import fcntl
import select
import subprocess
import sys
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

def test_it(made):
    assert len(tries) > {failures}
"""

LEAVES_SOMETHING = """
import pytest
tries = []

@pytest.fixture(scope="session")
def deep():
    return []

@pytest.fixture(scope="module")
def shared(deep):
    yield deep
    if len(tries) == 2:
        raise OSError("it is stuck")

def test_it(shared):
    tries.append(len(tries))
    assert not shared
    shared.append("left")
    assert len(tries) > {failures}

def test_the_next(shared):
    assert shared == ["left"]
"""

CANNOT_BEGIN = """
import pytest

@pytest.fixture
def made():
    raise OSError("no sound")

def test_it(made):
    pass
"""

HAS_NO_TIME = """
import keeping_up
from pathlib import Path
from keeping_up import pytest_runtest_protocol, pytest_terminal_summary
keeping_up.ROOM = Path({room!r})
keeping_up.STALL, keeping_up.PATIENCE = -1.0, 0.0
"""

ENTERS = """
import sys
from pathlib import Path
import keeping_up
keeping_up.ROOM = Path(sys.argv[1])
with keeping_up._room(alone=sys.argv[2] == "alone"):
    print("inside", flush=True)
    sys.stdin.readline()
"""


@pytest.fixture(autouse=True)
def of_its_own(pytester: pytest.Pytester, monkeypatch: pytest.MonkeyPatch) -> None:
    """A folder with the hooks of these tests, and a room."""
    monkeypatch.setattr(keeping_up, "ROOM", pytester.path / "room.lock")
    pytester.makeconftest("from keeping_up import pytest_runtest_protocol, pytest_terminal_summary")
    pytester.syspathinsert(Path(keeping_up.__file__).parent)


def outcome(pytester: pytest.Pytester, failures: int) -> str:
    """Run a test that fails so often, and tell how it ended and whether it was tried again."""
    return outcome_of(pytester, FAILS_TWICE.format(failures=failures), "assert 1 > ")


def outcome_of(pytester: pytest.Pytester, test: str, first: str) -> str:
    """The same of any test, and of what its first try failed."""
    pytester.makepyfile(test)
    result = pytester.runpytest_inprocess("-p", "no:cacheprovider")
    _, told, why = result.stdout.str().partition(keeping_up.AGAIN)
    assert not told or first in why
    (ended,) = result.parseoutcomes()
    return f"{ended}{', tried again' if told else ''}"


@pytest.mark.parametrize("late", [("CROWDED", -1.0), ("STALL", -1.0)])
def test_on_a_machine_that_has_no_time_a_test_has_eight_tries(
    late: tuple[str, float], pytester: pytest.Pytester, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(keeping_up, *late)
    monkeypatch.setattr(keeping_up, "PATIENCE", 0.0)
    assert outcome(pytester, failures=0) == "passed"
    assert outcome(pytester, failures=7) == "passed, tried again"
    assert outcome(pytester, failures=8) == "failed, tried again"
    assert outcome_of(pytester, CANNOT_BEGIN, "no sound") == "errors, tried again"


def test_on_a_machine_that_has_the_first_failure_counts(
    pytester: pytest.Pytester, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(keeping_up, "CROWDED", 1000.0)
    monkeypatch.setattr(keeping_up, "STALL", 1000.0)
    assert outcome(pytester, failures=1) == "failed"
    assert outcome(pytester, failures=0) == "passed"


def test_each_try_finds_nothing_that_another_left(
    pytester: pytest.Pytester, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(keeping_up, "STALL", -1.0)
    monkeypatch.setattr(keeping_up, "PATIENCE", 0.0)
    pytester.makepyfile(LEAVES_SOMETHING.format(failures=3))
    result = pytester.runpytest_inprocess("-p", "no:cacheprovider")
    result.assert_outcomes(passed=2)
    result.stdout.fnmatch_lines(["  taking it down: OSError('it is stuck')"])


@pytest.mark.slow
def test_each_try_has_as_much_time_as_the_first(pytester: pytest.Pytester) -> None:
    pytester.makeconftest(HAS_NO_TIME.format(room=str(pytester.path / "room.lock")))
    pytester.makeini(
        "[pytest]\nfaulthandler_timeout = 3\nfaulthandler_exit_on_timeout = true\n"
        f"pythonpath = {Path(keeping_up.__file__).parent}"
    )
    pytester.makepyfile("import time\n\n\ndef test_it():\n    time.sleep(0.7)\n    assert False\n")
    result = pytester.runpytest_subprocess("-p", "no:cacheprovider")
    result.assert_outcomes(failed=1)
    assert result.duration > 5


def test_a_file_that_cannot_be_read_is_told_as_ever(pytester: pytest.Pytester) -> None:
    pytester.makepyfile("import there_is_no_such_module")
    result = pytester.runpytest_inprocess("-p", "no:cacheprovider")
    result.assert_outcomes(errors=1)
    result.stdout.fnmatch_lines(["*No module named 'there_is_no_such_module'"])
    assert result.ret == pytest.ExitCode.INTERRUPTED


def busy_for(spells: int, monkeypatch: pytest.MonkeyPatch) -> list[bool]:
    """Let the machine have no time for some spells; gives what is asked of them."""
    asked: list[bool] = []

    def keeps_up(_: keeping_up.Metronome) -> bool:
        asked.append(len(asked) == spells)
        return asked[-1]

    monkeypatch.setattr(keeping_up.Metronome, "keeps_up", property(keeps_up))
    monkeypatch.setattr(keeping_up, "CALM", 0.01)
    return asked


def test_a_try_alone_waits_until_the_machine_has_time(monkeypatch: pytest.MonkeyPatch) -> None:
    asked = busy_for(3, monkeypatch)
    keeping_up._wait_for_calm(pytest.Stash())
    assert asked == [False, False, False, True]


def test_no_try_waits_for_ever(monkeypatch: pytest.MonkeyPatch) -> None:
    asked = busy_for(100_000, monkeypatch)
    monkeypatch.setattr(keeping_up, "PATIENCE", 0.03)
    monkeypatch.setattr(keeping_up, "IN_ALL", 0.05)
    stash = pytest.Stash()
    for _ in range(2):
        keeping_up._wait_for_calm(stash)
    waited = len(asked)
    assert waited
    keeping_up._wait_for_calm(stash)
    assert len(asked) == waited


def test_who_runs_alone_waits_for_those_before_and_is_waited_for(tmp_path: Path) -> None:
    room = tmp_path / "room"

    def enters(how: str) -> subprocess.Popen[str]:
        return subprocess.Popen(
            [sys.executable, "-c", ENTERS, room, how],
            cwd=Path(keeping_up.__file__).parent,
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            text=True,
        )

    def is_inside(process: subprocess.Popen[str], seconds: float = 60) -> bool:
        assert process.stdout
        return bool(select.select([process.stdout], [], [], seconds)[0])

    with enters("among") as first, enters("among") as second:
        assert is_inside(first)
        assert is_inside(second)
        with enters("alone") as alone:
            while not _entrance_is_taken(room):
                assert alone.poll() is None
            with enters("among") as later:
                first.communicate("\n")
                assert not is_inside(alone, 0.3)
                second.kill()
                assert is_inside(alone)
                assert not is_inside(later, 1)
                alone.communicate("\n")
                assert is_inside(later)
                later.communicate("\n")


def _entrance_is_taken(room: Path) -> bool:
    with room.open("a+") as file:
        try:
            fcntl.lockf(file, fcntl.LOCK_EX | fcntl.LOCK_NB, 1, 0)
        except OSError:
            return True
    return False
