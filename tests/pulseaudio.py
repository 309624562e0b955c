"""A microphone and a loudspeaker without hardware: two null sinks of a PulseAudio server."""

from __future__ import annotations

import os
import signal
import subprocess
import tempfile
import time
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

import numpy as np
import pytest
from programs import PATIENCE

# Without norewinds the first 1.4 to 2 s of a capture never arrive.
SINK = "load-module module-null-sink rate=16000 channels=1 format=s16le norewinds=1 sink_name="


@pytest.fixture(scope="session")
def pulse() -> Iterator[dict[str, str]]:
    """The environment in which a program speaks into `speaker` and hears what goes into `mic`.

    PortAudio looks for devices once for each process, so the program is to be a new one.
    """
    with sound_server() as (environment, _):
        yield environment


@pytest.fixture
def own_pulse() -> Iterator[tuple[dict[str, str], subprocess.Popen[bytes]]]:
    """The same for one test alone, and the server, which it may end."""
    with sound_server() as environment_and_server:
        yield environment_and_server


@pytest.fixture
def no_sound(tmp_path: Path) -> dict[str, str]:
    """The environment in which a program finds neither microphone nor loudspeaker."""
    config = tmp_path / "alsa.conf"
    config.write_text("pcm.default { type hw card 99 }")  # PortAudio aborts with an empty one
    return os.environ | {"ALSA_CONFIG_PATH": str(config)}


def pactl(environment: dict[str, str], call: str) -> str:
    """Ask the server for something; gives what it answers."""
    return subprocess.check_output(["pactl", *call.split()], env=environment, text=True)


@contextmanager
def sound_server() -> Iterator[tuple[dict[str, str], subprocess.Popen[bytes]]]:
    # Not tmp_path: the name of a socket must be short.
    with tempfile.TemporaryDirectory(prefix="voz-pulse-") as name:
        folder = Path(name)
        (folder / "run").mkdir(mode=0o700)
        (folder / "voz.pa").write_text(
            ".fail\n"
            f"load-module module-native-protocol-unix auth-anonymous=1 socket={folder}/native\n"
            f"{SINK}mic\n"
            f"{SINK}speaker\n"
            "set-default-sink speaker\n"
            "set-default-source mic.monitor\n"
        )
        environment = os.environ | {
            "HOME": str(folder),
            "XDG_RUNTIME_DIR": str(folder / "run"),
            "PULSE_RUNTIME_PATH": str(folder / "run" / "pulse"),
            "PULSE_SERVER": f"unix:{folder}/native",
        }
        with running_server(environment) as server:
            yield environment, server


@contextmanager
def running_server(environment: dict[str, str]) -> Iterator[subprocess.Popen[bytes]]:
    """Run the server of an environment; once it was killed, a new one can take its place."""
    folder = Path(environment["HOME"])
    (folder / "native").unlink(missing_ok=True)  # a killed server leaves its socket
    options = (
        "-n -F voz.pa --use-pid-file=no --exit-idle-time=-1 --disable-shm --daemonize=no "
        "--realtime=no --high-priority=no --log-target=stderr"
    )
    with subprocess.Popen(
        ["pulseaudio", *options.split()],
        cwd=folder,
        env=environment,
        stderr=subprocess.DEVNULL,
    ) as server:
        try:
            wait_for_server(environment)
            with room_noise(environment):
                yield server
        finally:
            server.send_signal(signal.SIGCONT)
            server.terminate()


@contextmanager
def room_noise(environment: dict[str, str]) -> Iterator[subprocess.Popen[bytes]]:
    """Let the microphone hear what it does in a quiet room: none that is on gives exact zeros."""
    room = Path(environment["HOME"]) / "room.raw"
    if not room.exists():
        quiet = np.random.default_rng(0).integers(-2, 3, 60 * 16_000)
        room.write_bytes(quiet.astype("<i2").tobytes())
    with playing_on(environment, room) as noise:
        yield noise


@contextmanager
def playing_on(environment: dict[str, str], raw: Path) -> Iterator[subprocess.Popen[bytes]]:
    """Let the microphone hear a file of 16-bit samples over and over again."""
    playing = "pacat --device=mic --latency-msec=100 --rate=16000 --channels=1 --format=s16le --raw"
    with subprocess.Popen(
        ["sh", "-c", f"while cat {raw.name}; do :; done | {playing}"],
        cwd=raw.parent,
        env=environment,
        stderr=subprocess.DEVNULL,
        start_new_session=True,  # a group of its own, to be ended with all its children
    ) as noise:
        try:
            yield noise
        finally:
            os.killpg(noise.pid, signal.SIGKILL)


def wait_for_server(environment: dict[str, str]) -> None:
    deadline = time.monotonic() + PATIENCE
    while subprocess.run(["pactl", "info"], env=environment, capture_output=True).returncode:
        assert time.monotonic() < deadline, "pulseaudio did not start"
        time.sleep(0.05)
