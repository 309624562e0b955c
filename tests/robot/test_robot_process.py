"""A robot in a process of its own, which stops it when the run cannot."""

from __future__ import annotations

import os
import signal
import subprocess
import threading
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from multiprocessing.connection import Connection, Pipe
from pathlib import Path

import msgspec
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from programs import PATIENCE, is_alive, wait_until

from voz.errors import RobotError
from voz.events import Event, Reply, Twist, Utterance, to_json
from voz.robot.child import RUN_TIMEOUT
from voz.robot.robot_process import MAX_OUTPUT_LINE, RobotProcess, RobotSpec, command

MODULE = """
import time
from pathlib import Path
from voz.events import Reply, Twist, to_json
from voz.robot.base import Robot

class Mine(Robot):
    gone = None
    def open(self):
        self.log = open("log", "w", buffering=1)
        print("opened")
    def receive(self, event):
        if isinstance(event, Reply):
            exec(event.text)
        self.log.write(to_json(event) + "\\n")
    def lost(self):
        return self.gone
    def close(self):
        self.log.write("closed\\n")

class Shut(Robot):
    move = None
    def open(self):
        raise OSError("no such port")

class Bad(Mine):
    gone = object()

class Unreadable(Robot):
    move = None
    def open(self):
        raise OSError("no port \\udcff")

class Slow(Mine):
    def open(self):
        super().open()
        while not Path("go").exists():
            time.sleep(0.01)
        if Path("go").read_text():
            raise OSError("no such port")
"""

AHEAD, REST = Twist(1, 0.1, 0), Twist(2, 0, 0)


@contextmanager
def process(kind: str = "Mine") -> Iterator[tuple[RobotProcess, list[str]]]:
    printed: list[str] = []
    robot = RobotProcess(RobotSpec(f"own:{kind}"), printed.append)
    try:
        robot.open()
        yield robot, printed
    finally:
        robot.end()


@contextmanager
def child(kind: str) -> Iterator[tuple[Connection, subprocess.Popen[str]]]:
    """The process of a robot, and the run's end of its connection, which a test may close."""
    ours, theirs = Pipe()
    descriptor, pipe = theirs.fileno(), subprocess.PIPE
    with subprocess.Popen(
        command(descriptor), pass_fds=[descriptor], stdout=pipe, stderr=subprocess.STDOUT, text=True
    ) as program:
        theirs.close()
        ours.send_bytes(msgspec.json.encode(RobotSpec(f"own:{kind}")))
        yield ours, program


def killed_run_after(*events: Event) -> None:
    """A run that ends without a word after some events, as by kill -9; waits for its robot."""
    with child("Mine") as (link, program):
        link.recv_bytes()
        for event in events:
            link.send_bytes(to_json(event).encode())
            link.recv_bytes()
        assert program.stdout
        program.stdout.close()
        link.close()
        program.wait(60)


def process_of(robot: RobotProcess) -> int:
    """Its number."""
    robot.receive(Reply(0, "import os; open('process', 'w').write(str(os.getpid()))"))
    return int(Path("process").read_text())


@pytest.fixture(autouse=True)
def here(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    (tmp_path / "own.py").write_text(MODULE)
    monkeypatch.chdir(tmp_path)


def got() -> list[str]:
    return Path("log").read_text().splitlines()


def velocities() -> list[float]:
    return [0.1 if '"linear":0.1' in line else 0.0 for line in got() if "cmd_vel" in line]


def test_it_gets_the_events_in_order_prints_and_is_closed() -> None:
    with process() as (robot, printed):
        for event in (AHEAD, Reply(1.5, "print('done')"), REST):
            robot.receive(event)
        robot.close()
        wait_until(lambda: printed == ["opened", "done"])
    assert [line[:17] for line in got()] == [
        '{"type":"cmd_vel"', '{"type":"reply","', '{"type":"cmd_vel"', "closed",
    ]  # fmt: skip


def test_what_opening_raises_is_one_line_with_its_place() -> None:
    with pytest.raises(RobotError, match=r"own:Shut cannot .*no such port \(own.py, line 24\)"):
        process("Shut").__enter__()


def test_whether_it_is_lost_comes_with_each_event() -> None:
    with process() as (robot, _):
        robot.receive(Reply(1, "self.gone = 'no answer'"))
        assert robot.lost() == "no answer"
        robot.receive(Reply(1, "self.gone = None"))
        assert robot.lost() is None


GIVEN_BACK = st.one_of(
    st.text(st.characters()).map(repr),  # with halves of pairs: names of files that are not UTF-8
    st.binary().map(repr),
    st.integers().map(repr),
    st.sampled_from(
        [
            "None",
            "True",
            "False",
            "object",
            "object()",
            "float('nan')",
            "('gone',)",
            "'x' * 1_000_000",
            "type('Sore', (), {'__bool__': lambda self: 1 / 0})()",
            "type('Sore', (str,), {'__getitem__': lambda self, at: object()})('sore')",
        ]
    ),
)
"""What a robot may give back by mistake, as Python."""

RAISED = [
    "OSError",
    "SystemExit",
    "KeyboardInterrupt",
    "GeneratorExit",
    "SyntaxError",
    "type('Sore', (BaseException,), {'__str__': lambda self: 1 / 0})",
    "type('Sore', (Exception,), {'__str__': lambda self: exit()})",
    "__import__('voz').RobotError",
]


def check_it_stops(robot: RobotProcess, mistake: str) -> None:
    """It drives, its own code does something, and it is stopped by the next velocity of zero."""
    robot.receive(AHEAD)
    with suppress(RobotError):
        robot.receive(Reply(1, mistake))
    assert robot.lost() is None or msgspec.json.encode(robot.lost())
    assert len(robot.lost() or "") <= 10_000
    with suppress(RobotError):
        robot.receive(REST)
    assert velocities()[-1] == 0.0
    robot.receive(Reply(3, "self.gone = None"))


def test_it_stops_and_is_closed_whatever_its_robot_gives_back() -> None:
    with process() as (robot, _):

        @settings(max_examples=100)
        @given(GIVEN_BACK)
        def whatever(given_back: str) -> None:
            check_it_stops(robot, f"self.gone = {given_back}")

        whatever()
        robot.close()
    assert got()[-1] == "closed"


def test_it_stops_and_is_closed_whatever_its_robot_raises() -> None:
    with process() as (robot, _):

        @settings(max_examples=100)
        @given(st.sampled_from(RAISED), GIVEN_BACK)
        def whatever(error: str, said: str) -> None:
            check_it_stops(robot, f"raise {error}({said})")

        whatever()
        robot.close()
    assert got()[-1] == "closed"


def test_what_it_prints_cannot_write_on_the_terminal() -> None:
    with process() as (robot, printed):
        robot.receive(Reply(0, r"print('\x1b[2J\u202eall good')"))
        wait_until(lambda: printed[1:] == [r"\u202eall good"])


def test_what_it_prints_without_an_end_is_shown_in_parts() -> None:
    with process() as (robot, printed):
        robot.receive(Reply(0, f"print('x' * {3 * MAX_OUTPUT_LINE}, end='')"))
        wait_until(lambda: printed[1:] == ["x" * MAX_OUTPUT_LINE] * 3)
        robot.receive(Reply(1, "print(); print(); print('done')"))
        wait_until(lambda: printed[4:] == ["", "done"])


@pytest.mark.parametrize("kind", ["Bad", "Unreadable"])
def test_what_it_gives_back_when_it_is_opened_is_one_line(kind: str) -> None:
    with pytest.raises(RobotError, match=rf"^the robot own:{kind} cannot be used here: [^\n]+$"):
        process(kind).__enter__()
    assert kind != "Bad" or got() == ["closed"]


@pytest.mark.parametrize(
    "fault",
    [
        "from multiprocessing import connection; connection.Connection.send_bytes = None",
        "import voz.robot.child as child; child.msgspec = None",
    ],
)
def test_a_fault_in_its_process_leaves_it_stopped_and_closed(fault: str) -> None:
    with process() as (robot, printed):
        robot.receive(AHEAD)
        with suppress(RobotError):
            robot.receive(Reply(1, fault))
        with suppress(RobotError):
            robot.receive(AHEAD)
        wait_until(lambda: got()[-1] == "closed")
        assert velocities()[-1] == 0.0
        assert printed == ["opened"]


def test_it_is_stopped_though_it_has_used_up_all_descriptors() -> None:
    use_up = (
        "import os, resource\n"
        "resource.setrlimit(resource.RLIMIT_NOFILE, (64, 64))\n"
        "try:\n"
        "    while True: os.dup(0)\n"
        "except OSError: pass"
    )
    killed_run_after(AHEAD, Reply(1, use_up))
    assert got()[-1] == "closed"
    assert velocities()[-1] == 0.0


def test_what_closing_raises_is_one_line() -> None:
    with process() as (robot, printed):
        robot.receive(Reply(1, "self.close = lambda: 1 / 0"))
        robot.close()
        wait_until(lambda: len(printed) == 2)
    assert printed[1] == (
        "the robot could not be closed: ZeroDivisionError: division by zero (<string>, line 1)"
    )


def test_it_gets_events_with_names_of_files_that_are_not_utf_8() -> None:
    with process() as (robot, _):
        robot.receive(Utterance(1, "stop", 1.0, True, 0, 1, "caf\udce9.wav"))
        assert robot.lost() is None
    assert '"source":"caf?.wav"' in got()[0]


@pytest.mark.slow
def test_when_the_beat_falls_silent_it_is_stopped_and_stays_so_until_the_run_stops_it() -> None:
    with process() as (robot, _):
        robot.receive(AHEAD)
        wait_until(lambda: velocities()[-1] == 0.0)
        robot.receive(AHEAD)  # the run was suspended, and knows nothing of it
        assert robot.lost() == f"nothing came for {RUN_TIMEOUT:g} s"
        assert velocities()[-1] == 0.0
        robot.receive(REST)
        assert robot.lost() is None
        robot.receive(AHEAD)
        assert velocities()[-1] == 0.1


@pytest.mark.realtime
@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGTERM, signal.SIGHUP, signal.SIGQUIT])
def test_signals_for_the_run_do_not_end_it(number: int) -> None:
    with process() as (robot, _):
        robot.receive(AHEAD)
        os.kill(process_of(robot), number)
        robot.receive(REST)
        assert velocities() == [0.1, 0.0]


def test_a_run_that_is_gone_without_a_word_leaves_it_stopped_and_closed() -> None:
    killed_run_after(AHEAD)
    assert got()[-1] == "closed"
    assert velocities()[-1] == 0.0


@pytest.mark.parametrize(("fault", "still"), [("", {0.0}), ("fails", set())])
def test_a_run_that_ends_while_its_robot_opens_leaves_it_closed_without_a_word(
    fault: str, still: set[float], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("PYTHONUNBUFFERED", "1")
    with child("Slow") as (link, program):
        wait_until(Path("log").exists)
        link.close()
        Path("go").write_text(fault)
        printed, _ = program.communicate(timeout=PATIENCE)
    assert (printed, program.returncode) == ("opened\n", 0)
    assert set(velocities()) == still
    assert got()[-1:] == ["closed"] * bool(still)


def test_a_process_that_is_killed_is_an_error() -> None:
    with process() as (robot, _):
        number = process_of(robot)
        os.kill(number, signal.SIGKILL)
        wait_until(lambda: not is_alive(number))
        with pytest.raises(RobotError, match="its process has ended"):
            robot.receive(AHEAD)


@pytest.mark.slow
def test_a_robot_that_hangs_for_ever_is_ended() -> None:
    with process() as (robot, _):
        number = process_of(robot)

        def hang() -> None:
            with suppress(RobotError):
                robot.receive(Reply(1, "open('hangs', 'w').close(); time.sleep(999)"))

        waiting = threading.Thread(target=hang)
        waiting.start()
        wait_until(Path("hangs").exists)
    waiting.join()
    assert not is_alive(number)
