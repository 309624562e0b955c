from __future__ import annotations

import ctypes.util
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest
import soundfile

from voz.audio.capture.microphone import open_microphone
from voz.errors import AudioError

LISTEN = """
import sys
import numpy as np
from voz.audio.capture.microphone import open_microphone
from voz.errors import AudioError
device, seconds, path = sys.argv[1] or None, float(sys.argv[2]), sys.argv[3]
try:
    with open_microphone(device) as blocks:
        heard = [next(blocks)]
        print("listening", flush=True)
        while sum(map(len, heard)) < seconds * 16000:
            heard.append(next(blocks))
    np.concatenate(heard).tofile(path)
except AudioError as error:
    print(error)
"""

ONE_RATE = """
import sounddevice
check = sounddevice.check_input_settings
def check_input_settings(*arguments, samplerate, **others):
    if samplerate != 44100:
        raise sounddevice.PortAudioError("Invalid sample rate")
    check(*arguments, samplerate=samplerate, **others)
sounddevice.check_input_settings = check_input_settings
"""


def listen(
    environment: dict[str, str], path: Path, device: str = "", seconds: float = 2, before: str = ""
) -> subprocess.Popen[str]:
    """Listen in a new process, where PortAudio looks for devices anew."""
    command = [sys.executable, "-c", before + LISTEN, device, str(seconds), str(path)]
    return subprocess.Popen(command, env=environment, stdout=subprocess.PIPE, text=True)


def error_of(process: subprocess.Popen[str]) -> str:
    output, _ = process.communicate(timeout=60)
    return output.removeprefix("listening\n")


def chirp() -> np.ndarray:
    """One second from 200 to 2000 Hz: it resembles itself at a single place only."""
    seconds = np.arange(16000) / 16000
    return (10_000 * np.sin(2 * np.pi * (200 + 900 * seconds) * seconds)).astype(np.int16)


def likeness_to_what_is_played(
    sink: str, process: subprocess.Popen[str], pulse: dict[str, str], tmp_path: Path
) -> float:
    """Play a chirp, and correlate it with what a process that listens has kept of it."""
    soundfile.write(tmp_path / "chirp.wav", chirp(), 16000)
    assert process.stdout is not None
    assert process.stdout.readline() == "listening\n"
    speak = ["paplay", f"--device={sink}", str(tmp_path / "chirp.wav")]
    subprocess.run(speak, env=pulse, check=True)
    assert error_of(process) == ""
    heard = np.fromfile(tmp_path / "heard.raw", np.int16).astype(float)
    at = int(np.argmax(np.correlate(heard, chirp().astype(float), "valid")))
    return float(np.corrcoef(heard[at : at + 16000], chirp())[0, 1])


@pytest.mark.realtime
@pytest.mark.slow
@pytest.mark.parametrize("before", ["", ONE_RATE])
def test_what_is_spoken_into_the_microphone_is_heard(
    before: str, pulse: dict[str, str], tmp_path: Path
) -> None:
    process = listen(pulse, tmp_path / "heard.raw", seconds=3, before=before)
    assert likeness_to_what_is_played("mic", process, pulse, tmp_path) > 0.99


@pytest.mark.realtime
@pytest.mark.slow
def test_a_source_of_the_sound_server_is_heard_though_it_is_not_the_default(
    pulse: dict[str, str], tmp_path: Path
) -> None:
    process = listen(pulse, tmp_path / "heard.raw", device="speaker.monitor", seconds=3)
    assert likeness_to_what_is_played("speaker", process, pulse, tmp_path) > 0.99


@pytest.mark.slow
def test_an_unknown_microphone_is_one_line_with_those_that_there_are(
    pulse: dict[str, str], tmp_path: Path
) -> None:
    message = error_of(listen(pulse, tmp_path / "heard.raw", device="nobody has this"))
    assert message.startswith('there is no microphone "nobody has this"; take ')
    assert message.count("\n") == 1
    assert "pulse" in message


def test_a_computer_without_microphone_gives_one_line(
    no_sound: dict[str, str], tmp_path: Path
) -> None:
    for device in ("", "3", "mic"):
        message = error_of(listen(no_sound, tmp_path / "heard.raw", device))
        assert message == "there is no microphone; connect one and start again\n"


@pytest.mark.slow
def test_a_microphone_that_is_taken_away_is_one_line(
    own_pulse: tuple[dict[str, str], subprocess.Popen[bytes]], tmp_path: Path
) -> None:
    environment, server = own_pulse
    process = listen(environment, tmp_path / "heard.raw", seconds=60)
    assert process.stdout is not None
    assert process.stdout.readline() == "listening\n"
    server.kill()
    assert error_of(process) in ("the microphone is gone; connect it and start again\n",)


def test_missing_portaudio_gives_the_line_to_install_it(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.delitem(sys.modules, "sounddevice", raising=False)
    monkeypatch.setattr(ctypes.util, "find_library", lambda name: None)
    with pytest.raises(AudioError, match=r"libportaudio2$"), open_microphone():
        pass
