from __future__ import annotations

import ctypes.util
import os
import subprocess
import sys
from pathlib import Path

import numpy as np
import numpy.typing as npt
import pytest
import soundfile

from voz.audio.playback import play
from voz.errors import AudioError

PLAY = """
import sys
from pathlib import Path
from voz.audio.playback import play
from voz.errors import AudioError
try:
    play(Path(sys.argv[1]))
except AudioError as error:
    print(error)
"""

ONE_RATE = """
import sounddevice
def check_output_settings(samplerate, **others):
    if samplerate != 44100:
        raise sounddevice.PortAudioError("Invalid sample rate")
sounddevice.check_output_settings = check_output_settings
"""


def play_in(environment: dict[str, str], path: Path, before: str = "") -> str:
    """Play a file in a new process, where PortAudio looks for devices anew; give the error."""
    done = subprocess.run(
        [sys.executable, "-c", before + PLAY, str(path)],
        env=environment,
        capture_output=True,
        text=True,
        check=True,
        timeout=60,
    )
    return done.stdout


def with_alsa(folder: Path, device: str) -> dict[str, str]:
    """An environment with a single sound device."""
    config = folder / "alsa.conf"
    config.write_text(f"pcm.default {{ {device} }}")
    return os.environ | {"ALSA_CONFIG_PATH": str(config)}


def sweep(rate: int) -> npt.NDArray[np.float64]:
    """One second from 200 to 2000 Hz: it resembles itself at a single place only."""
    time = np.arange(rate) / rate
    wave: npt.NDArray[np.float64] = 0.5 * np.sin(2 * np.pi * (200 + 900 * time) * time)
    return wave


def resemblance(heard: npt.NDArray[np.float64], played: npt.NDArray[np.float64]) -> float:
    """The correlation of what was played with the stretch of `heard` that is most like it."""
    shift = int(np.argmax(np.correlate(heard, played, "valid")))
    return float(np.corrcoef(heard[shift : shift + len(played)], played)[0, 1])


@pytest.fixture
def wav(tmp_path: Path) -> Path:
    soundfile.write(tmp_path / "sweep.wav", sweep(16000), 16000)
    return tmp_path / "sweep.wav"


@pytest.mark.slow
@pytest.mark.parametrize(("rate", "before"), [(16000, ""), (16000, ONE_RATE), (32000, ONE_RATE)])
def test_all_of_a_file_is_heard(
    rate: int, before: str, pulse: dict[str, str], tmp_path: Path
) -> None:
    soundfile.write(tmp_path / "sweep.wav", sweep(rate), rate)
    record = "parecord --device=speaker.monitor --rate=16000 --channels=1 --format=s16le --raw"
    with (tmp_path / "heard.raw").open("wb") as file:
        recorder = subprocess.Popen([*record.split(), "--latency-msec=50"], env=pulse, stdout=file)
    try:
        assert play_in(pulse, tmp_path / "sweep.wav", before) == ""
    finally:
        recorder.terminate()
        recorder.wait()
    heard = np.fromfile(tmp_path / "heard.raw", np.int16) / 32768
    assert resemblance(heard, sweep(16000)) > 0.99


@pytest.mark.parametrize(("rate", "channels"), [(8000, 1), (44100, 2), (96000, 1)])
def test_any_rate_and_stereo_can_be_played(rate: int, channels: int, tmp_path: Path) -> None:
    soundfile.write(tmp_path / "noise.flac", np.zeros((rate // 2, channels)), rate)
    assert play_in(with_alsa(tmp_path, "type null"), tmp_path / "noise.flac") == ""


def test_a_computer_without_loudspeaker_gives_one_line(wav: Path, tmp_path: Path) -> None:
    message = play_in(with_alsa(tmp_path, "type hw card 99"), wav)
    assert message == "there is no loudspeaker; connect one and start again\n"


def test_missing_portaudio_gives_the_line_to_install_it(
    wav: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.delitem(sys.modules, "sounddevice", raising=False)
    monkeypatch.setattr(ctypes.util, "find_library", lambda name: None)
    with pytest.raises(AudioError, match=r"^PortAudio is not installed; .* libportaudio2$"):
        play(wav)


@pytest.mark.slow
def test_playing_can_be_stopped_from_another_thread(pulse: dict[str, str], tmp_path: Path) -> None:
    soundfile.write(tmp_path / "minute.wav", np.zeros(60 * 16000), 16000)
    script = """
import sys, threading, time
from pathlib import Path
from voz.audio.playback import play
stopped = threading.Event()
thread = threading.Thread(target=play, args=(Path(sys.argv[1]), stopped))
thread.start()
time.sleep(0.5)
stopped.set()
thread.join()
"""
    command = [sys.executable, "-c", script, str(tmp_path / "minute.wav")]
    subprocess.run(command, env=pulse, check=True, timeout=30)


def test_a_missing_file_is_named(tmp_path: Path) -> None:
    with pytest.raises(AudioError, match=r"none\.wav: cannot be read \(No such file"):
        play(tmp_path / "none.wav")


def test_a_file_that_holds_no_sound_is_named(tmp_path: Path) -> None:
    (tmp_path / "text.wav").write_text("hello")
    with pytest.raises(AudioError, match=r"text\.wav: is no recording that can be read"):
        play(tmp_path / "text.wav")
