"""What comes out of the loudspeaker of a test."""

from __future__ import annotations

import os
import subprocess
import threading
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager

import numpy as np
import numpy.typing as npt
import pytest
from programs import PATIENCE

from voz.audio import portaudio

Heard = npt.NDArray[np.float64]

RATE = 16_000
"""Of what is heard, Hz."""

RECORD = f"parecord --device=speaker.monitor --rate={RATE} --channels=1 --format=s16le --raw"


class Recorder:
    """Hears all that comes out, from when it was made."""

    def __init__(self, environment: dict[str, str]) -> None:
        command = [*RECORD.split(), "--latency-msec=20"]
        self._process = subprocess.Popen(command, env=environment, stdout=subprocess.PIPE)
        self._data = bytearray()
        self._thread = threading.Thread(target=self._read, daemon=True)
        self._thread.start()
        self.pass_by(0.1)

    def _read(self) -> None:
        assert self._process.stdout is not None
        while data := os.read(self._process.stdout.fileno(), 1 << 16):
            self._data += data

    def heard(self) -> Heard:
        """All samples up to now, -1 to 1."""
        return np.frombuffer(bytes(self._data[: len(self._data) // 2 * 2]), np.int16) / 32768

    def pass_by(self, seconds: float) -> Heard:
        """Let so much more be heard, and give it."""
        before = len(self.heard())
        deadline = time.monotonic() + PATIENCE
        while len(self.heard()) < before + seconds * RATE:
            assert time.monotonic() < deadline, "nothing is recorded"
            time.sleep(0.01)
        return self.heard()[before:]

    def close(self) -> None:
        self._process.kill()
        self._process.wait()
        self._thread.join()
        assert self._process.stdout is not None
        self._process.stdout.close()


@contextmanager
def recording(environment: dict[str, str]) -> Iterator[Recorder]:
    recorder = Recorder(environment)
    try:
        yield recorder
    finally:
        recorder.close()


@pytest.fixture
def loudspeaker(pulse: dict[str, str], monkeypatch: pytest.MonkeyPatch) -> Iterator[Recorder]:
    """This process plays into a loudspeaker that is recorded."""
    play_into(pulse, monkeypatch)
    with recording(pulse) as recorder:
        yield recorder


def play_into(environment: dict[str, str], monkeypatch: pytest.MonkeyPatch) -> None:
    """Let this process use the sound server of an environment."""
    for name in ("HOME", "XDG_RUNTIME_DIR", "PULSE_RUNTIME_PATH", "PULSE_SERVER"):
        monkeypatch.setenv(name, environment[name])
    portaudio.refresh_devices()


def at_16_khz(wave: npt.NDArray[np.float32]) -> Heard:
    """What a 48 kHz sound should be like when it is heard."""
    import soxr

    return np.asarray(soxr.resample(wave, 48_000, RATE), np.float64)


def place_of(wave: Heard, heard: Heard) -> tuple[int, float]:
    """Where in `heard` something like `wave` is, and how alike it is: the correlation.

    The samples of both may stand a part of a sample apart.
    """
    shift = int(np.argmax(np.abs(np.correlate(heard, wave, "valid"))))
    stretch = heard[shift : shift + len(wave)]
    turns = np.fft.rfftfreq(len(wave))
    parts = np.linspace(-0.5, 0.5, 11)
    spectrum = np.fft.rfft(wave)
    moved = [np.fft.irfft(spectrum * np.exp(2j * np.pi * turns * p), len(wave)) for p in parts]
    return shift, max(float(np.corrcoef(stretch, other)[0, 1]) for other in moved)


def likeness(wave: Heard, heard: Heard) -> float:
    """How alike the stretch of `heard` is that is most like `wave`."""
    return place_of(wave, heard)[1]


def is_silent(heard: Heard) -> bool:
    return bool(np.abs(heard).max(initial=0) < 0.002)


def best(attempt: Callable[[], float], enough: float, tries: int = 8) -> float:
    """The best of several attempts: a busy machine interrupts some sounds."""
    found = -1.0
    for _ in range(tries):
        found = max(found, attempt())
        if found > enough:
            break
    return found
