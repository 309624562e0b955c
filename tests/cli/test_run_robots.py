"""`voz run --robot`: several robots, real time, and what is drawn."""

from __future__ import annotations

import fcntl
import itertools
import os
import pty
import re
import select
import signal
import struct
import subprocess
import sys
import termios
import time
import tty
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import IO, Any

import pytest
from calls import VOZ, Result, in_process
from programs import PATIENCE
from recordings import ROOT, Recording

MOVES = ("cmd_vel", "selected_object")
LINES = "start speech\ngo forward\n-\n-\nstop\n"


def changes(run: Result) -> list[Any]:
    """What the robot was asked to do, each as long as it was asked; it stands still before."""
    asked = [e.get("value") or (e["linear"], e["angular"]) for e in run.json if e["type"] in MOVES]
    return [after for before, after in itertools.pairwise([(0, 0), *asked]) if before != after]


def said(run: Result) -> list[tuple[Any, ...]]:
    """What was said to the robot and by it, and whether it was obeyed."""
    return [(e["type"], e["text"], e.get("obeyed")) for e in run.json if e["type"] not in MOVES]


@pytest.fixture
def typed(tmp_path: Path) -> Path:
    path = tmp_path / "typed.txt"
    path.write_text(LINES)
    return path


class SerialPort:
    """The other end of a serial port, which is a terminal here."""

    def __init__(self) -> None:
        self._ours, self._theirs = pty.openpty()
        tty.setraw(self._theirs)  # a terminal makes two characters of each line's end
        self.name = os.ttyname(self._theirs)
        self._came = b""

    def read_text(self) -> str:
        """All that came up to now."""
        while select.select([self._ours], [], [], 0)[0]:
            self._came += os.read(self._ours, 65536)
        return self._came.decode()

    def close(self) -> None:
        os.close(self._theirs)
        os.close(self._ours)


@pytest.fixture
def serial_robot(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Iterator[SerialPort]:
    """What a robot on a serial port gets; docs/robots.md shows its class."""
    port = SerialPort()
    write_serial_robot(tmp_path, port.name)
    monkeypatch.syspath_prepend(tmp_path)
    monkeypatch.setenv("PYTHONPATH", str(tmp_path), prepend=os.pathsep)
    monkeypatch.delitem(sys.modules, "serial_robot", raising=False)
    yield port
    port.close()


def write_serial_robot(folder: Path, port: str) -> None:
    page = (Path(__file__).parents[2] / "docs" / "robots.md").read_text()
    code = page.split("# serial_robot.py\n")[1].split("```")[0]
    (folder / "serial_robot.py").write_text(code.replace("/dev/ttyUSB0", port))


def test_several_robots_get_the_same_and_voz_toml_names_them_too(
    voz: Any, typed: Path, tmp_path: Path
) -> None:
    picture = tmp_path / "way.svg"
    arguments = ["run", "--text", typed, "--no-sound", "--picture", picture]
    by_option = voz(*arguments, "--robot", "console", "--robot", "simulator")
    assert "drives forward" in by_option.out
    drawn = picture.read_bytes()
    (tmp_path / "voz.toml").write_text('robot = ["console", "simulator"]\n')
    by_file = voz(*arguments, "--config", tmp_path / "voz.toml")
    assert by_file.out == by_option.out
    assert picture.read_bytes() == drawn


@pytest.mark.slow
def test_a_picture_shows_what_a_recording_made_the_simulator_do(
    voz: Any, session: Recording, tmp_path: Path
) -> None:
    picture = tmp_path / "way.svg"
    result = voz(
        "run", "--wav", session.path, "--no-sound", "--robot", "simulator", "--picture", picture
    )
    assert result.code == 0
    assert result.out.splitlines()[2].split() == ["3.6", "s", "heard", '"go', 'forward"', "(1.00)"]
    written = [f"drawing {picture} ...", f"written: {picture}, the way of the robot"]
    assert result.err.splitlines() == written
    assert "go forward" in picture.read_text()
    title = re.search(r"[\d.]+ m in \d+ s, driven by \d+ commands", picture.read_text())
    assert title
    assert title.group().encode() in (ROOT / "docs" / "demo.png").read_bytes()


@pytest.mark.realtime
def test_after_ctrl_c_it_says_what_it_draws_and_what_it_wrote(tmp_path: Path) -> None:
    picture, animation = tmp_path / "way.svg", tmp_path / "way.gif"
    command = [*VOZ, "run", "--text", "-", "--no-sound", "--realtime", "--events", "-"]
    drawn = ["--robot", "simulator", "--picture", str(picture), "--animation", str(animation)]
    with subprocess.Popen(
        [*command, *drawn],
        stdin=subprocess.PIPE,
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
    ) as process:
        try:
            assert process.stdout
            assert process.stdout.readline()  # it drives
            process.send_signal(signal.SIGINT)
            _, told = process.communicate(timeout=60)
        finally:
            process.kill()
    assert process.returncode == 130
    written = [line.split(",")[0] for line in told.splitlines() if line.startswith("written: ")]
    assert written == [f"written: {picture}", f"written: {animation}"]
    assert told.startswith(f"drawing {picture} ...\n")
    assert f"drawing {animation} ...\n" in told
    assert animation.read_bytes().startswith(b"GIF8")


@pytest.mark.parametrize(
    ("arguments", "complaint"),
    [
        (["--robot", "sim"], "there is no robot sim"),
        (["--picture", "a.png"], "add --robot simulator"),
        (["--robot", "simulator", "--picture", "a.jpg"], "end it with .png or .svg"),
        (["--robot", "simulator", "--animation", "no/a.gif"], "cannot be written there"),
        (["--robot", "no_module:Robot"], "the robot no_module:Robot cannot be used here"),
        (["--robot", "json:JSONDecoder"], "the robot json:JSONDecoder has no open()"),
    ],
)
def test_what_cannot_be_is_told_before_the_run(
    arguments: list[str], complaint: str, voz: Any, typed: Path
) -> None:
    result = voz("run", "--text", typed, *arguments)
    assert complaint in result.complaint
    assert result.out == ""


def test_who_wants_to_know_all_about_a_mistake_is_told_it(typed: Path, tmp_path: Path) -> None:
    (tmp_path / "my_arm.py").write_text("import no_driver\n")
    arguments = ["run", "--text", typed, "--robot", "my_arm:Arm"]
    line = in_process(*arguments, cwd=tmp_path).complaint
    assert line.endswith("No module named 'no_driver' (my_arm.py, line 1)")
    done = subprocess.run(
        [*VOZ, *map(str, arguments), "-v"], capture_output=True, text=True, cwd=tmp_path
    )
    assert done.returncode == 2
    assert "Traceback" in done.stderr
    assert done.stderr.splitlines()[-1] == line


@pytest.mark.parametrize("place", ["1 / 0", "'here'", "(0, 0)", "object()"])
def test_a_mistake_in_the_odometry_of_ones_own_robot_is_one_line(
    place: str, typed: Path, tmp_path: Path
) -> None:
    (tmp_path / "lost_robot.py").write_text(
        "from voz.robot.base import Robot\n"
        "class Lost(Robot):\n"
        "    def move(self, linear, angular):\n"
        "        print(linear, angular)\n"
        "    def place(self, t):\n"
        f"        return {place}\n"
    )
    done = subprocess.run(
        [*VOZ, "run", "--text", typed, "--no-sound", "--no-watchdog", "--robot", "lost_robot:Lost"],
        capture_output=True,
        text=True,
        cwd=tmp_path,
    )
    assert done.returncode == 2
    assert "voz: the robot lost_robot:Lost cannot be used here: " in done.stderr
    assert "Traceback" not in done.stderr
    assert done.stdout.splitlines()[-1] == "0.0 0.0"


def test_a_collision_is_a_warning_among_the_events(voz: Any, tmp_path: Path) -> None:
    (tmp_path / "typed.txt").write_text("start speech\ngo back\n" + "-\n" * 80)
    arguments = ["run", "--text", tmp_path / "typed.txt", "--robot", "simulator", "--no-sound"]
    result = voz(*arguments, "--events", "-")
    (warning,) = [event for event in result.json if event["type"] == "warning"]
    assert warning["text"].startswith("the robot hit a wall at x 0.17 m")
    times = [event["t"] for event in result.json]
    assert times == sorted(times)
    assert "the robot hit a wall" in result.err  # where people read


@pytest.mark.realtime
def test_a_robot_of_ten_lines_gets_every_velocity_and_zero_last(
    voz: Any, typed: Path, serial_robot: SerialPort
) -> None:
    result = voz("run", "--text", typed, "--no-sound", "--robot", "serial_robot:SerialRobot")
    assert (result.code, result.err) == (0, "")
    sent = serial_robot.read_text().splitlines()
    assert sent[-1] == "0.00 0.00"
    assert "0.10 0.00" in sent


@pytest.mark.parametrize("is_there", [False, True])
def test_where_no_serial_port_is_none_is_made(
    is_there: bool, voz: Any, typed: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    port = tmp_path / "ttyUSB0"
    if is_there:
        port.write_text("a file\n")
    write_serial_robot(tmp_path, str(port))
    monkeypatch.syspath_prepend(tmp_path)
    result = voz("run", "--text", typed, "--no-sound", "--robot", "serial_robot:SerialRobot")
    assert f"{port} is not a serial port: plug the adapter in" in result.complaint
    assert port.exists() == is_there
    assert not is_there or port.read_text() == "a file\n"


@pytest.mark.realtime
def test_a_robot_that_fails_stops_the_others_and_is_named(
    voz: Any, typed: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    (tmp_path / "bad_robot.py").write_text(
        "class Bad:\n"
        "    def open(self): pass\n"
        "    def lost(self): return None\n"
        "    def close(self): pass\n"
        "    def receive(self, event):\n"
        "        if getattr(event, 'linear', 0): raise OSError('the cable is out')\n"
    )
    monkeypatch.syspath_prepend(tmp_path)
    typed.write_text("start speech\ngo forward\n" + "-\n" * 6)
    result = voz(
        "run", "--text", typed, "--no-sound", "--robot", "bad_robot:Bad,console", "--events", "-"
    )
    (warning,) = [event["text"] for event in result.json if event["type"] == "warning"]
    assert warning.startswith("the robot bad_robot:Bad is lost (OSError: the cable is out (")
    assert warning.endswith("bad_robot.py, line 6)): the robot stops")
    assert result.code == 2
    assert result.err.splitlines()[-1].startswith("voz: the robot bad_robot:Bad failed (OSError: ")
    assert changes(result) == [(0.1, 0), (0, 0)]
    moves = [event["linear"] for event in result.json if event["type"] == "cmd_vel"]
    assert moves[-4:] == [0, 0, 0, 0]
    assert "drives forward" in result.err
    assert "stands still" in result.err


@pytest.mark.realtime
def test_where_no_robot_shows_it_a_loss_is_a_warning_and_what_is_back_is_none(
    voz: Any, typed: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    (tmp_path / "wavering.py").write_text(
        "from voz.robot.base import Robot\n"
        "class Wavering(Robot):\n"
        "    asked = 0\n"
        "    def receive(self, event): pass\n"
        "    def lost(self):\n"
        "        self.asked += 1\n"
        "        return 'asleep' if 4 <= self.asked <= 8 else None\n"
    )
    monkeypatch.syspath_prepend(tmp_path)
    typed.write_text("-\n" * 12)
    name = "wavering:Wavering"
    result = voz("run", "--text", typed, "--no-sound", "--realtime", "--robot", name)
    assert [line for line in result.err.splitlines() if name in line] == [
        f"warning: the robot {name} is lost (asleep): the robot stops",
        f"{name} is there; the robot waits for a command",
    ]


@pytest.mark.parametrize("name", ["drive.mcap", "drive.bag", "drive"])
def test_a_bag_of_a_spoken_run_drives_again(
    name: str, voz: Any, session: Recording, tmp_path: Path
) -> None:
    arguments = ["--no-sound", "--events", "-"]
    first = voz("run", "--wav", session.path, "--bag", tmp_path / name, *arguments)
    second = voz("run", "--replay", tmp_path / name, *arguments)
    assert (first.code, second.code) == (0, 0)
    # A bag has no partials, which let a stop that is spoken take effect a little earlier.
    assert changes(first) == changes(second)
    assert len(changes(first)) == 7 + 2 * 2  # after an object the velocity comes again
    again = voz("run", "--wav", session.path, "--bag", tmp_path / name, *arguments)
    assert "is there already" in again.complaint
    assert again.out == ""


@contextmanager
def driven_by_text(serial_robot: SerialPort, *arguments: str) -> Iterator[subprocess.Popen[str]]:
    """A `voz run` that has been told to go forward."""
    command = [*VOZ, "run", "--text", "-", "--no-sound", "--robot", "serial_robot:SerialRobot"]
    with subprocess.Popen(
        [*command, *arguments],
        stdin=subprocess.PIPE,
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
    ) as process:
        try:
            type_line(process, "start speech\ngo forward")
            wait_for(lambda: "0.10" in serial_robot.read_text(), process)
            yield process
        finally:
            process.kill()


def type_line(process: subprocess.Popen[str], line: str) -> None:
    assert process.stdin
    process.stdin.write(f"{line}\n")
    process.stdin.flush()


def wait_for(reached: Callable[[], bool], process: subprocess.Popen[str]) -> None:
    deadline = time.monotonic() + PATIENCE
    while not reached():
        assert process.poll() is None
        assert time.monotonic() < deadline
        time.sleep(0.02)


def unread(pipe: IO[str]) -> int:
    """How many bytes nobody has read yet."""
    (count,) = struct.unpack("i", fcntl.ioctl(pipe, termios.FIONREAD, bytes(4)))
    return int(count)


@pytest.mark.realtime
def test_a_robot_stops_though_nobody_reads_the_events(serial_robot: SerialPort) -> None:
    with driven_by_text(serial_robot, "--events", "-") as process:
        assert process.stdout
        size = fcntl.fcntl(process.stdout, fcntl.F_SETPIPE_SZ, 4096)
        type_line(process, "what is all this\n" * (size // len("what is all this")))
        wait_for(lambda: unread(process.stdout) > size - 500, process)
        before = len(serial_robot.read_text().splitlines())
        wait_for(lambda: len(serial_robot.read_text().splitlines()) > before + 10, process)
        type_line(process, "stop")
        wait_for(lambda: serial_robot.read_text().endswith("0.00 0.00\n"), process)
        process.send_signal(signal.SIGTERM)
        assert process.wait(PATIENCE) == 143


@pytest.mark.realtime
def test_s7_a_signal_sends_zero_last_to_a_robot_with_a_thread(serial_robot: SerialPort) -> None:
    with driven_by_text(serial_robot) as process:
        assert process.stderr
        process.send_signal(signal.SIGTERM)
        assert process.wait(PATIENCE) == 143
        assert process.stderr.read() == ""
    assert serial_robot.read_text().splitlines()[-1] == "0.00 0.00"


@pytest.mark.realtime
def test_two_runs_never_drive_by_one_serial_port(serial_robot: SerialPort, typed: Path) -> None:
    with driven_by_text(serial_robot) as process:
        other = in_process(
            "run", "--text", typed, "--no-sound", "--robot", "serial_robot:SerialRobot"
        )
        assert f"{serial_robot.name} is in use by process " in other.complaint
        assert "--robot serial_robot:SerialRobot): end that, or name another" in other.complaint
        type_line(process, "stop")
        wait_for(lambda: serial_robot.read_text().endswith("0.00 0.00\n"), process)
        after = serial_robot.read_text().rpartition("0.10 0.00\n")[2]
        assert set(after.splitlines()) == {"0.00 0.00"}
    # That one was killed just now; its robot's process goes on for a moment.
    again = in_process("run", "--text", typed, "--no-sound", "--robot", "serial_robot:SerialRobot")
    assert (again.code, again.err) == (0, "")


@pytest.mark.slow
@pytest.mark.parametrize("arguments", [[], ["--realtime"]])
def test_a_terminal_shows_the_room(arguments: list[str], typed: Path) -> None:
    ours, theirs = pty.openpty()
    command = [*VOZ, "run", "--text", str(typed), "--no-sound", "--robot", "simulator,console"]
    with subprocess.Popen(
        [*command, *arguments],
        stdout=theirs,
        stderr=theirs,
        env=os.environ | {"TERM": "xterm", "COLUMNS": "80", "LINES": "40"},
    ) as process:
        os.close(theirs)
        shown = b""
        while data := _read(ours):
            shown += data
    os.close(ours)
    assert process.returncode == 0
    text = shown.decode()
    assert "drives forward at 0.10 m/s" in text
    assert any("\u2801" <= character <= "\u28ff" for character in text)
    assert (text.count("B") > 1) == bool(arguments)  # drawn again and again, or once


def _read(descriptor: int) -> bytes:
    try:
        return os.read(descriptor, 65536)
    except OSError:  # Linux says so when the other end is closed
        return b""
