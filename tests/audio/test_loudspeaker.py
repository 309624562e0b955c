"""Loudspeakers that are not there, want another rate, or hang."""

from __future__ import annotations

import ctypes.util
import os
import signal
import subprocess
import sys
import time
from pathlib import Path

import numpy as np
import pytest
import sounddevice
from loudspeaker import Recorder, at_16_khz, best, likeness
from pulseaudio import running_server

from voz.audio.loudspeaker import Loudspeaker
from voz.audio.mixer import Mixer
from voz.audio.playback import PLAYBACK_RATE, Wave

NO_LOUDSPEAKER = "there is no loudspeaker; connect one"

PLAY_TWICE = """
import numpy as np
from voz.audio.loudspeaker import Loudspeaker
from voz.audio.mixer import Mixer
mixer = Mixer(print)
for _ in range(2):
    mixer.wait(mixer.play(np.full(4800, 0.1, np.float32)))
mixer.close()
"""

PLAY_ON = """
import time
import numpy as np
from voz.audio.loudspeaker import Loudspeaker
from voz.audio.mixer import Mixer
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
