"""The thread that hears: a real microphone, what it puts into the inbox, and how it is lost."""

from __future__ import annotations

import json
import signal
import subprocess
import sys
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
from live_robot import speak
from programs import PATIENCE
from pulseaudio import running_server
from recordings import GO_BACK

from voz.api.recognizer import Recognizer
from voz.audio.channels import OUT_OF_PHASE
from voz.audio.microphone import MICROPHONE_BLOCK_SECONDS, ONLY_SILENCE, Microphone
from voz.events import Notice
from voz.hearing.microphone_thread import (
    LOSS_WARNING_INTERVAL,
    MUTE_WARNING,
    MUTED_AFTER,
    Hearing,
    SilenceCheck,
    SoundSource,
    SoundWatch,
)
from voz.inbox import Inbox

Pulse = tuple[dict[str, str], "subprocess.Popen[bytes]"]

# PortAudio looks for devices once for each process, so each test has a new one. It answers each
# line that it reads: `look` by how it is, and `end` by whether its thread still runs.
HEAR = """
import json, sys, threading, time
import msgspec
from voz import load
from voz.errors import AudioError
from voz.hearing.microphone_thread import Hearing, sound_card
from voz.inbox import Inbox

def tell(**what):
    print(json.dumps(what), flush=True)

inbox, begun = Inbox({"stop"}), time.monotonic()
def heard():
    found = []
    while (message := inbox.take(0.0001)) is not None:
        found.append(msgspec.to_builtins(message))
    return found

def look(hearing, moving):
    trouble = hearing.trouble(moving)
    tell(trouble=trouble, peak=hearing.peak, background=hearing.background,
         speaking=hearing.speaking, device=hearing.device,
         now=time.monotonic() - begun, heard=heard())

hearing = Hearing(load(), sound_card(sys.argv[1] or None), inbox, lambda: time.monotonic() - begun)
try:
    with hearing:
        for line in sys.stdin:
            if line == "end\\n":
                break
            look(hearing, moving=line == "look moving\\n")
    tell(running=[each.name for each in threading.enumerate() if each.name == "voz-hearing"])
except AudioError as error:
    tell(error=str(error))
"""


class Listener:
    """A process that hears."""

    def __init__(self, process: subprocess.Popen[str]) -> None:
        self._process = process
        self.heard: list[dict[str, Any]] = []

    def ask(self, line: str) -> dict[str, Any]:
        """Ask for something; gives the answer, and keeps what it has heard since."""
        assert self._process.stdin
        assert self._process.stdout
        self._process.stdin.write(f"{line}\n")
        self._process.stdin.flush()
        answer: dict[str, Any] = json.loads(self._process.stdout.readline())
        self.heard += answer.get("heard", [])
        return answer

    def until(self, sought: Callable[[dict[str, Any]], bool], line: str = "look") -> dict[str, Any]:
        """Ask again and again until an answer is as it is sought."""
        deadline = time.monotonic() + PATIENCE
        while not sought(answer := self.ask(line)):
            assert time.monotonic() < deadline, (answer, self.heard)
            time.sleep(0.05)
        return answer

    def utterances(self) -> list[dict[str, Any]]:
        """What it has understood so far."""
        return [each for each in self.heard if each["type"] == "utterance"]

    def warnings(self, begin: str) -> list[dict[str, Any]]:
        """What it has warned of so far, in words that begin so."""
        told = [each for each in self.heard if each["type"] == "warning"]
        return [each for each in told if each["text"].startswith(begin)]


@contextmanager
def listening(environment: dict[str, str], device: str = "") -> Iterator[Listener]:
    with subprocess.Popen(
        [sys.executable, "-c", HEAR, device],
        env=environment,
        stdin=subprocess.PIPE,
        stdout=subprocess.PIPE,
        text=True,
    ) as process:
        try:
            yield Listener(process)
        finally:
            process.kill()


def is_well(answer: dict[str, Any]) -> bool:
    return answer["trouble"] is None


def is_lost(answer: dict[str, Any]) -> bool:
    return answer["trouble"] is not None


@pytest.mark.realtime
@pytest.mark.slow
def test_what_is_said_comes_by_the_clock_of_the_run(pulse: dict[str, str]) -> None:
    with listening(pulse) as listener:
        before = listener.until(is_well)["now"]
        speak(pulse, GO_BACK)
        after = listener.until(lambda _: bool(listener.utterances()))["now"]
        (said,) = listener.utterances()
    assert (said["text"], said["accepted"], said["source"]) == ("go back", True, "microphone")
    assert before < said["start"] < said["end"] < said["t"] < after
    # The last word ends before the stretch of speech does, and both before it is told.
    assert said["start"] < said["t"] - said["latency"] <= said["end"]


@pytest.mark.slow
def test_the_level_and_the_name_are_there_to_be_shown(pulse: dict[str, str]) -> None:
    with listening(pulse, "mic.monitor") as listener:
        quiet = listener.until(lambda answer: is_well(answer) and answer["peak"] > 0)
        assert quiet["device"] == "mic.monitor"
        assert quiet["peak"] < 0.01
        assert not quiet["speaking"]
        speaking = subprocess.Popen(["paplay", "--device=mic", str(GO_BACK)], env=pulse)
        loud = listener.until(lambda answer: answer["peak"] > 0.1)
        assert loud["peak"] <= 1
        assert loud["background"] < -30
        assert speaking.wait() == 0


@pytest.mark.slow
def test_at_the_end_of_the_block_nobody_listens_any_more(pulse: dict[str, str]) -> None:
    with listening(pulse) as listener:
        listener.until(is_well)
        assert listener.ask("end") == {"running": []}


@pytest.mark.slow
def test_a_microphone_that_is_not_there_ends_the_block_before_it_begins(
    pulse: dict[str, str],
) -> None:
    with listening(pulse, "nobody has this") as listener:
        assert 'there is no microphone "nobody has this"' in listener.ask("look")["error"]


@pytest.mark.slow
def test_while_it_is_lost_nothing_is_shown_and_then_it_hears_again(own_pulse: Pulse) -> None:
    environment, server = own_pulse
    with listening(environment) as listener:
        listener.until(lambda answer: is_well(answer) and answer["peak"] > 0)
        server.kill()
        lost = listener.until(lambda answer: is_lost(answer) and answer["peak"] == 0)
        assert not lost["speaking"]
        with running_server(environment):
            listener.until(is_well)
            assert listener.utterances() == []  # nobody has said anything yet
            speak(environment, GO_BACK)
            listener.until(lambda _: bool(listener.utterances()))
    (said,) = listener.utterances()
    assert said["text"] == "go back"
    assert said["start"] > lost["now"]


@pytest.mark.slow
def test_a_server_that_hangs_is_noticed_though_nothing_fails(own_pulse: Pulse) -> None:
    environment, server = own_pulse
    with listening(environment) as listener:
        listener.until(is_well)
        server.send_signal(signal.SIGSTOP)
        silent = listener.until(is_lost)
        assert silent["trouble"] == "no sound comes from the microphone"
        server.send_signal(signal.SIGCONT)
        listener.until(is_well)


@pytest.mark.slow
def test_a_muted_microphone_is_warned_of_once_and_is_lost_only_for_a_robot_that_moves(
    own_pulse: Pulse,
) -> None:
    environment, _ = own_pulse
    mute = ["pactl", "set-source-mute", "mic.monitor"]
    subprocess.run([*mute, "1"], env=environment, check=True)
    with listening(environment) as listener:
        listener.until(lambda _: bool(listener.warnings(ONLY_SILENCE)))
        assert is_well(listener.ask("look"))
        assert listener.ask("look moving")["trouble"] == ONLY_SILENCE
        assert listener.ask("look")["trouble"] == ONLY_SILENCE  # it moved, and nobody could stop it
        subprocess.run([*mute, "0"], env=environment, check=True)
        listener.until(is_well)
        assert len(listener.warnings(ONLY_SILENCE)) == 1


SECOND = np.zeros(16000, np.int16)


def warnings(inbox: Inbox) -> list[str]:
    """What was told since the last look."""
    told = []
    while (message := inbox.take(0)) is not None:
        assert isinstance(message, Notice)
        told.append(message.text)
    return told


def test_silence_matters_from_a_motion_on_until_something_is_heard() -> None:
    silence = SilenceCheck()
    looks = [  # whether it is silent, whether the robot moves, what is told
        (True, False, None),
        (False, True, None),
        (True, True, ONLY_SILENCE),
        (True, False, ONLY_SILENCE),  # nobody could have stopped it
        (False, False, None),
        (True, False, None),
    ]
    assert [silence.trouble(*look) for *look, _ in looks] == [told for *_, told in looks]


def test_a_microphone_that_is_muted_is_told_once_until_something_is_heard() -> None:
    inbox = Inbox(["stop"])
    watch = SoundWatch(inbox, lambda: 0.0)
    for _ in range(2 * int(MUTED_AFTER)):
        assert watch.check(SECOND, 0) == 0.0
    assert watch.zeros == 2 * MUTED_AFTER
    assert warnings(inbox) == [MUTE_WARNING]
    assert watch.check(SECOND - 16384, 0) == 0.5
    assert watch.zeros == 0.0
    for _ in range(int(MUTED_AFTER)):
        watch.check(SECOND, 0)
    assert warnings(inbox) == [MUTE_WARNING]


def test_sound_that_is_lost_again_and_again_is_told_now_and_then() -> None:
    now = 0.0
    inbox = Inbox(["stop"])
    watch = SoundWatch(inbox, lambda: now)
    watch.check(SECOND + 1, 1)
    watch.check(SECOND + 1, 3)
    now = LOSS_WARNING_INTERVAL
    watch.check(SECOND + 1, 4)
    lost = [f"{blocks * MICROPHONE_BLOCK_SECONDS:.2f} s of sound were lost" for blocks in (1, 3)]
    assert [line.split(":")[0] for line in warnings(inbox)] == lost


def test_channels_out_of_phase_are_told_once(recognizer: Recognizer) -> None:
    tone = (0.1 * np.sin(np.arange(480) / 5)).astype(np.float32)
    block = np.stack([tone, -tone], axis=1).tobytes()
    opened = []

    @contextmanager
    def plugged_in() -> Iterator[Microphone]:
        opened.append(microphone := Microphone("headset", 16_000, 2))
        for _ in range(9):
            microphone.heard(block, 480, None, SimpleNamespace(input_overflow=False))
        microphone.ended()  # it is plugged in again
        yield microphone

    inbox = Inbox({"stop"})
    with Hearing(recognizer, SoundSource(plugged_in), inbox, lambda: 0.0):
        while len(opened) < 3:
            time.sleep(0.01)
    told = list(iter(lambda: inbox.take(0.0001), None))
    assert [message for message in told if isinstance(message, Notice)] == [
        Notice(0.0, f"microphone: {OUT_OF_PHASE}")
    ]
