"""Loudspeakers that are not there, want another rate, or hang."""

from __future__ import annotations

import ctypes.util
import os
import signal
import subprocess
import sys
import time
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

import numpy as np
import pytest
import sounddevice
from loudspeaker import (
    Heard,
    Recorder,
    at_16_khz,
    best,
    is_silent,
    likeness,
    place_of,
    play_into,
    recording,
)
from programs import wait_until
from pulseaudio import running_server

from voz.audio import loudspeaker as device
from voz.audio.loudspeaker import Loudspeaker, Mixer
from voz.audio.playback import PLAYBACK_RATE, Wave

NO_LOUDSPEAKER = "there is no loudspeaker; connect one"

PLAY_TWICE = """
import numpy as np
from voz.audio.loudspeaker import Loudspeaker
from voz.audio.loudspeaker import Mixer
mixer = Mixer(print)
for _ in range(2):
    mixer.wait(mixer.play(np.full(4800, 0.1, np.float32)))
mixer.close()
"""

PLAY_ON = """
import time
import numpy as np
from voz.audio.loudspeaker import Loudspeaker
from voz.audio.loudspeaker import Mixer
mixer = Mixer(lambda line: print(line, flush=True))
source = mixer.play(np.full(4800, 0.1, np.float32), repeats=True)
while not mixer.recent(0.5)[0].any():
    time.sleep(0.05)
print("playing", flush=True)
input()
late = mixer.play(np.full(4800, 0.1, np.float32))
mixer.wait(late)
mixer.close()
print("closed", flush=True)
"""


def run(script: str, environment: dict[str, str]) -> tuple[str, str]:
    """What a new process, where PortAudio looks for devices anew, prints."""
    command = [sys.executable, "-c", script]
    done = subprocess.run(
        command, env=environment, capture_output=True, text=True, check=True, timeout=60
    )
    return done.stdout, done.stderr


def playing_on(environment: dict[str, str]) -> subprocess.Popen[str]:
    """A new process that plays until it gets a line."""
    pipe = subprocess.PIPE
    command = [sys.executable, "-c", PLAY_ON]
    return subprocess.Popen(command, env=environment, stdin=pipe, stdout=pipe, text=True)


def with_alsa(folder: Path, device: str) -> dict[str, str]:
    """An environment with a single sound device."""
    config = folder / "alsa.conf"
    config.write_text(f"pcm.default {{ {device} }}")
    return os.environ | {"ALSA_CONFIG_PATH": str(config)}


def test_a_computer_without_a_loudspeaker_gives_one_warning(tmp_path: Path) -> None:
    printed = run(PLAY_TWICE, with_alsa(tmp_path, "type hw card 99"))
    assert printed == (f"{NO_LOUDSPEAKER}\n", "")


def test_a_device_of_alsa_alone_is_enough(tmp_path: Path) -> None:
    assert run(PLAY_TWICE, with_alsa(tmp_path, "type null")) == ("", "")


def test_a_program_that_just_ends_while_it_plays_ends_well(tmp_path: Path) -> None:
    script = PLAY_TWICE.replace("mixer.close()", "mixer.play(np.zeros(48000, np.float32))")
    assert run(script, with_alsa(tmp_path, "type null")) == ("", "")


def test_missing_portaudio_gives_the_line_to_install_it(monkeypatch: pytest.MonkeyPatch) -> None:
    warnings: list[str] = []
    monkeypatch.delitem(sys.modules, "sounddevice", raising=False)
    monkeypatch.setattr(ctypes.util, "find_library", lambda name: None)
    mixer = Mixer(warnings.append)
    mixer.wait(mixer.play(np.zeros(100, np.float32)))
    mixer.close()
    (warning,) = warnings
    assert warning.startswith("PortAudio is not installed; ")
    assert warning.endswith("libportaudio2")


@pytest.mark.realtime
def test_a_device_that_takes_another_rate_alone_is_played_at_that(
    loudspeaker: Recorder, monkeypatch: pytest.MonkeyPatch
) -> None:
    def check_output_settings(samplerate: int, **_: object) -> None:
        if samplerate != 44100:
            raise sounddevice.PortAudioError("Invalid sample rate")

    monkeypatch.setattr(sounddevice, "check_output_settings", check_output_settings)
    time = np.arange(PLAYBACK_RATE // 2) / PLAYBACK_RATE
    wave: Wave = (0.4 * np.sin(2 * np.pi * (300 + 2000 * time) * time)).astype(np.float32)
    problems: list[str] = []
    mixer = Mixer(problems.append)

    def played() -> float:
        before = len(loudspeaker.heard())
        mixer.wait(mixer.play(wave))
        loudspeaker.pass_by(0.3)
        return likeness(at_16_khz(wave), loudspeaker.heard()[before:])

    assert best(played, 0.99) > 0.99
    mixer.close()
    assert problems == []


def test_a_loudspeaker_that_comes_later_is_found(
    own_pulse: tuple[dict[str, str], subprocess.Popen[bytes]],
) -> None:
    environment, server = own_pulse
    server.kill()
    server.wait()
    with playing_on(environment) as program:
        assert program.stdout is not None
        assert program.stdout.readline() == f"{NO_LOUDSPEAKER}\n"
        with running_server(environment):
            assert program.stdout.readline() == "playing\n"
            assert program.communicate("\n", timeout=60)[0] == "closed\n"


@pytest.mark.slow
def test_a_sound_server_that_hangs_keeps_nobody_from_ending(
    own_pulse: tuple[dict[str, str], subprocess.Popen[bytes]],
) -> None:
    environment, server = own_pulse
    with playing_on(environment) as program:
        assert program.stdout is not None
        assert program.stdout.readline() == "playing\n"
        server.send_signal(signal.SIGSTOP)
        assert program.stdout.readline().startswith("the loudspeaker is gone; ")
        assert program.communicate("\n", timeout=60)[0] == "closed\n"
        assert program.returncode == 0


def test_what_cannot_begin_in_time_is_left_out(monkeypatch: pytest.MonkeyPatch) -> None:
    mixer = Mixer(lambda _: None)
    # As if opening the device took for ever.
    monkeypatch.setattr(Loudspeaker, "wake", lambda _: None)
    once = mixer.play(np.zeros(480, np.float32))
    again = mixer.play(np.zeros(480, np.float32), repeats=True)
    before = time.monotonic()
    mixer.wait(once)
    assert time.monotonic() - before > 1
    assert once.over
    assert not again.over
    mixer.close()
    assert again.over


pytestmark = pytest.mark.realtime


def sweep(seconds: float = 0.6, start: float = 300.0, end: float = 3000.0) -> Wave:
    """A tone that rises: it resembles itself at a single place only."""
    t = np.arange(int(seconds * PLAYBACK_RATE)) / PLAYBACK_RATE
    phase = 2 * np.pi * (start * t + (end - start) * t**2 / (2 * seconds))
    return (0.4 * np.sin(phase)).astype(np.float32)


def tone(frequency: float, seconds: float) -> Wave:
    """A whole number of periods, if they are."""
    t = np.arange(round(seconds * PLAYBACK_RATE)) / PLAYBACK_RATE
    return (0.4 * np.sin(2 * np.pi * frequency * t)).astype(np.float32)


@pytest.fixture
def warnings() -> list[str]:
    return []


@pytest.fixture
def mixer(loudspeaker: Recorder, warnings: list[str]) -> Mixer:
    mixer = Mixer(warnings.append)
    yield mixer
    mixer.close()


def played(mixer: Mixer, loudspeaker: Recorder, *waves: Wave, volume: float = 1.0) -> Heard:
    """Play sounds at once; give what is heard of them."""
    before = len(loudspeaker.heard())
    for source in [mixer.play(wave, volume) for wave in waves]:
        mixer.wait(source)
    loudspeaker.pass_by(0.2)
    return loudspeaker.heard()[before:]


def test_what_is_played_is_heard(mixer: Mixer, loudspeaker: Recorder, warnings: list[str]) -> None:
    wave = at_16_khz(sweep())
    assert best(lambda: likeness(wave, played(mixer, loudspeaker, sweep())), 0.99) > 0.99
    assert warnings == []


def test_two_sounds_at_once_are_both_there(mixer: Mixer, loudspeaker: Recorder) -> None:
    up, down = sweep(), sweep(start=6000, end=3500)
    sum_of_both = at_16_khz(up + down)
    mixer.wait(mixer.play(sweep()))  # then the loudspeaker is open, and both begin in one block
    alike = best(lambda: likeness(sum_of_both, played(mixer, loudspeaker, up, down)), 0.98)
    assert alike > 0.98
    assert likeness(at_16_khz(up), sum_of_both) == pytest.approx(0.7, abs=0.05)  # not one alone


def test_a_sound_that_is_too_long_to_wait_for_can_be_stopped(mixer: Mixer) -> None:
    source = mixer.play(np.zeros(600 * PLAYBACK_RATE, np.float32))
    mixer.stop(source)
    mixer.wait(source)


def test_many_threads_may_play_at_once(mixer: Mixer, warnings: list[str]) -> None:
    with ThreadPoolExecutor(8) as threads:
        sources = list(threads.map(mixer.play, [sweep(0.3) / 8] * 8))
    for source in sources:
        mixer.wait(source)
    time.sleep(0.1)
    assert 0.2 < np.abs(mixer.recent(2)[0]).max() < 0.5
    assert warnings == []


def test_it_is_known_how_long_it_is_heard(mixer: Mixer, loudspeaker: Recorder) -> None:
    assert mixer.busy_until() < time.monotonic()
    source = mixer.play(np.concatenate([sweep(), np.zeros(PLAYBACK_RATE, np.float32)]))
    assert time.monotonic() < mixer.busy_until() < time.monotonic() + 5
    mixer.wait(source)
    assert mixer.busy_until() < time.monotonic()  # the second of silence is not waited for
    repeated = mixer.play(sweep(), repeats=True)
    assert mixer.busy_until() == float("inf")
    mixer.stop(repeated)
    mixer.wait(repeated)
    while mixer.busy_until() > time.monotonic():
        time.sleep(0.01)
    # The recorder is up to 0.1 s behind, as it was found when it was made.
    loudspeaker.pass_by(0.1)
    assert is_silent(loudspeaker.pass_by(0.1))


def test_the_words_of_what_sounds_are_known_if_all_of_it_is_speech(mixer: Mixer) -> None:
    said = mixer.play(sweep(), text="good morning")
    assert mixer.replies() is None  # only `stop` counts
    mixer.barge_in = True
    assert mixer.replies() == "good morning"
    mixer.play(tone(500.0, 0.2))
    assert mixer.replies() is None
    mixer.stop(said)


def test_what_was_heard_is_remembered_and_when(mixer: Mixer, loudspeaker: Recorder) -> None:
    def likeness_in_time() -> float:
        mixer.wait(mixer.play(sweep()))
        until = mixer.busy_until()
        loudspeaker.pass_by(0.2)
        asked = time.monotonic()
        samples, end = mixer.recent(3.0)
        assert samples.shape == (48_000,)
        assert abs(end - asked) < 0.5
        shift, alike = place_of(at_16_khz(sweep()), samples)
        ended = end - (len(samples) - 1 - shift) / 16_000 + 0.6
        return alike if ended == pytest.approx(until, abs=0.1) else 0.0

    assert best(likeness_in_time, 0.99) > 0.99


MICROPHONE = "0"
"""The sink that the noise of the room is played to."""


def test_the_loudspeaker_is_closed_when_nothing_sounds(
    mixer: Mixer, loudspeaker: Recorder, pulse: dict[str, str], monkeypatch: pytest.MonkeyPatch
) -> None:
    def players() -> str:
        command = ["pactl", "list", "short", "sink-inputs"]
        inputs = subprocess.run(command, env=pulse, capture_output=True, text=True).stdout
        return "".join(line for line in inputs.splitlines(True) if line.split()[1] != MICROPHONE)

    monkeypatch.setattr(device, "MAX_IDLE_SECONDS", 0.2)
    mixer.prepare()
    wait_until(lambda: players() == "")
    source = mixer.play(sweep(), repeats=True)
    wait_until(lambda: len(players().splitlines()) == 1)
    mixer.stop(source)
    wait_until(lambda: players() == "")
    wave = at_16_khz(sweep())
    assert best(lambda: likeness(wave, played(mixer, loudspeaker, sweep())), 0.99) > 0.99


def test_after_closing_nothing_is_heard(mixer: Mixer, loudspeaker: Recorder) -> None:
    source = mixer.play(sweep(), repeats=True)
    loudspeaker.pass_by(0.3)
    mixer.close()
    mixer.close()
    assert source.over
    mixer.wait(mixer.play(sweep()))
    loudspeaker.pass_by(0.2)
    assert is_silent(loudspeaker.pass_by(0.5))


@pytest.mark.slow
def test_a_server_that_is_killed_is_told_once_and_used_again(
    own_pulse: tuple[dict[str, str], subprocess.Popen[bytes]],
    warnings: list[str],
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    environment, server = own_pulse
    play_into(environment, monkeypatch)
    mixer = Mixer(warnings.append)
    try:
        beat = mixer.play(tone(440, 0.1), 0.3, repeats=True)
        with recording(environment) as recorder:
            wait_until(lambda: not is_silent(recorder.pass_by(0.2)))
        server.kill()
        server.wait()
        lost = mixer.play(sweep())
        mixer.wait(lost)  # is left out
        time.sleep(2)  # some tries in vain
        assert mixer.busy_until() < time.monotonic()
        assert warnings == ["the loudspeaker is gone; it is used again as soon as it is back"]
        with running_server(environment), recording(environment) as recorder:
            wait_until(lambda: not is_silent(recorder.pass_by(0.2)))
            mixer.stop(beat)
            wave = at_16_khz(sweep())
            assert best(lambda: likeness(wave, played(mixer, recorder, sweep())), 0.99) > 0.99
    finally:
        mixer.close()
