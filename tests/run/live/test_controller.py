"""A robot that a program drives by a microphone."""

from __future__ import annotations

import subprocess
import sys
import time
from collections.abc import Callable
from contextlib import suppress
from threading import Thread

import pytest
from programs import PATIENCE
from recordings import FIXTURES

SAID = FIXTURES / "commands"

PROGRAM = """
import signal
import voz

class Wheels(voz.Robot):
    moving = None
    def move(self, linear, angular):
        if (linear, angular) != self.moving:
            self.moving = linear, angular
            print(f"{linear:g} {angular:g}", flush=True)

signal.signal(signal.SIGTERM, signal.default_int_handler)
try:
    with voz.Controller(Wheels(), safety=voz.Safety(max_linear=0.05), listening=True) as controller:
        controller.run(voz.load().microphone())
except KeyboardInterrupt:
    print("ended", flush=True)
"""


@pytest.mark.realtime
@pytest.mark.slow
def test_a_microphone_drives_a_robot(pulse: dict[str, str]) -> None:
    command = [sys.executable, "-c", PROGRAM]
    with subprocess.Popen(command, env=pulse, stdout=subprocess.PIPE, text=True) as process:
        lines: list[str] = []
        reader = Thread(target=_read, args=(process, lines), daemon=True)
        reader.start()
        wait_until(lambda: lines == ["0 0"])
        for text, velocity in (("go_forward", "0.05 0"), ("stop", "0 0")):
            speak_until(pulse, text, lambda wanted=velocity: lines[-1] == wanted)
        assert "0.05 0" in lines
        process.terminate()
        assert process.wait(PATIENCE) == 0
        reader.join(30)
    assert lines[-1] == "ended"


def _read(process: subprocess.Popen[str], lines: list[str]) -> None:
    assert process.stdout is not None
    for line in process.stdout:
        lines.append(line.strip())


def speak_until(pulse: dict[str, str], text: str, done: Callable[[], bool]) -> None:
    """Speak a clip; again where the machine was too slow to follow, which stops the robot."""
    deadline = time.monotonic() + 60
    while not done():
        assert time.monotonic() < deadline, text
        clip = SAID / f"festival_slt__{text}.flac"
        subprocess.run(["paplay", "--device=mic", str(clip)], env=pulse, check=True)
        with suppress(TimeoutError):
            wait_until(done, 3)


def wait_until(done: Callable[[], bool], seconds: float = PATIENCE) -> None:
    deadline = time.monotonic() + seconds
    while not done():
        if time.monotonic() > deadline:
            raise TimeoutError
        time.sleep(0.02)


ASLEEP = """
import voz
recognizer = voz.load(["go forward", "stop"])
with voz.Controller(voz.Robot()) as controller:
    try:
        controller.run(recognizer.microphone())
    except voz.ConfigError as error:
        print(error)
"""


@pytest.mark.slow
def test_a_list_that_cannot_begin_is_one_line(pulse: dict[str, str]) -> None:
    command = [sys.executable, "-c", ASLEEP]
    done = subprocess.run(command, env=pulse, capture_output=True, text=True, check=True)
    assert done.stdout == (
        'no command begins the listening; add "start speech" to the list, or give listening=True\n'
    )
