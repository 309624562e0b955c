"""`voz devices`: the microphones that there are, and what is wrong with one."""

from __future__ import annotations

import os
import pty
import subprocess
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

import numpy as np
import pytest
import soundfile
from calls import VOZ, in_process
from recordings import GO_BACK

from voz.audio import SAMPLE_RATE


@pytest.mark.slow
def test_the_microphones_are_listed_and_the_one_that_is_used_is_marked(
    own_pulse: tuple[dict[str, str], subprocess.Popen[bytes]],
) -> None:
    pulse, _ = own_pulse  # to a server that plays at 48 kHz its devices may have that rate
    header, *rows, legend = in_process("devices", env=pulse).out.splitlines()
    assert header.split() == ["name", "channels", "rate", "system"]
    assert [row.split()[:2] for row in rows[:2]] == [["0", "pulse"], [">", "1"]]
    assert rows[1].split()[2:] == ["default", "32", "44100", "Hz", "ALSA"]
    assert [row.split() for row in rows[2:]] == [
        ["mic.monitor", "1", "16000", "Hz", "PulseAudio"],
        ["speaker.monitor", "1", "16000", "Hz", "PulseAudio"],
    ]
    assert legend.startswith("> is used")
    _, *rows, _ = in_process("devices", "--device", "puls", env=pulse).out.splitlines()
    assert [row.split()[0] for row in rows[:2]] == [">", "1"]
    _, *rows, _ = in_process("devices", "--device", "mic.mon", env=pulse).out.splitlines()
    assert [row.split()[0] for row in rows] == ["0", "1", ">", "speaker.monitor"]


@pytest.mark.slow
def test_a_source_of_the_sound_server_is_tested_by_its_name(pulse: dict[str, str]) -> None:
    result = in_process("devices", "-d", "speaker.monitor", "--test", env=pulse)
    assert result.out.startswith('"speaker.monitor": say something now')
    assert "silent" in result.out  # nothing is played on it


@pytest.mark.slow
def test_an_unknown_microphone_is_one_line(pulse: dict[str, str]) -> None:
    for option in ([], ["--test"]):
        result = in_process("devices", "-d", "nobody", *option, env=pulse)
        assert 'there is no microphone "nobody"; take' in result.complaint
    result = in_process("devices", "-d", "9" * 5000, env=pulse)  # more digits than Python reads
    assert 'there is no microphone "999' in result.complaint


@pytest.mark.parametrize("option", [[], ["--test"], ["--device", "3"]])
def test_a_computer_without_microphone_is_one_line(
    option: list[str], no_sound: dict[str, str]
) -> None:
    complaint = in_process("devices", *option, env=no_sound).complaint
    assert complaint == "voz: there is no microphone; connect one and start again"


@pytest.fixture(scope="module")
def command() -> np.ndarray:
    return soundfile.read(GO_BACK)[0]


@pytest.mark.realtime
@pytest.mark.slow
@pytest.mark.parametrize(
    ("gain", "noise", "said"),
    [
        # tests/audio/test_recording_level.py has each fault.
        (1, 0, ["fine"]),
        (0.01, 0.0004, ["too quiet", "noisy"]),
        (0, 0, ["silent"]),
    ],
)
def test_what_is_spoken_into_the_microphone_is_judged(
    gain: float,
    noise: float,
    said: list[str],
    command: np.ndarray,
    pulse: dict[str, str],
    tmp_path: Path,
) -> None:
    hiss = np.random.default_rng(1).standard_normal(60 * SAMPLE_RATE) * noise
    soundfile.write(tmp_path / "hiss.wav", hiss, SAMPLE_RATE)
    soundfile.write(tmp_path / "said.wav", np.clip(gain * command, -1, 1), SAMPLE_RATE)
    with muted(pulse) if said == ["silent"] else playing(tmp_path / "hiss.wav", pulse):
        output = spoken_into(pulse, tmp_path / "said.wav")
    assert sum(line.startswith("level ") for line in output) == 6
    if gain:  # somebody spoke, so that the background means something
        assert " of 100 commands" in output[-1] or "said again" in output[-1]
        output = output[:-1]
    verdicts = [line for line in output[6:-4] if not line.startswith("  ")]
    assert [v[: len(s)] for v, s in zip(verdicts, said, strict=True)] == said
    advice = [line for line in output[6:-4] if line.startswith("  ")]
    assert len(advice) == len(verdicts if said != ["fine"] else [])
    figures = [line.split() for line in output[-4:]]
    assert [figure[0] for figure in figures] == ["peak", "speech", "background", "signal"]
    units = ["dBFS", "dBFS", "dBFS", "dB"] if gain else ["dBFS", "-", "dBFS", "-"]
    assert [figure[-1] for figure in figures] == units


@contextmanager
def playing(background: Path, environment: dict[str, str]) -> Iterator[None]:
    """Let the microphone hear something all the time."""
    command = ["paplay", "--device=mic", str(background)]
    with subprocess.Popen(command, env=environment) as player:
        try:
            yield
        finally:
            player.terminate()


@contextmanager
def muted(environment: dict[str, str]) -> Iterator[None]:
    """Switch the microphone off."""
    switch = ["pactl", "set-source-mute", "mic.monitor"]
    subprocess.run([*switch, "1"], env=environment, check=True)
    try:
        yield
    finally:
        subprocess.run([*switch, "0"], env=environment, check=True)


def spoken_into(environment: dict[str, str], said: Path) -> list[str]:
    """Speak as soon as one is asked to; returns what is printed afterwards."""
    with subprocess.Popen(
        [*VOZ, "devices", "--test"], env=environment, stdout=subprocess.PIPE, text=True
    ) as process:
        assert process.stdout is not None
        assert "say something" in process.stdout.readline()
        subprocess.run(["paplay", "--device=mic", str(said)], env=environment, check=True)
        output, _ = process.communicate(timeout=60)
    assert process.returncode == 0
    return output.splitlines()


@pytest.mark.realtime
@pytest.mark.slow
def test_in_a_terminal_a_bar_moves(pulse: dict[str, str]) -> None:
    terminal, its_end = pty.openpty()
    environment = pulse | {"TERM": "xterm-256color", "COLUMNS": "100"}
    command = [*VOZ, "devices", "--test"]
    with subprocess.Popen(command, env=environment, stdin=its_end, stdout=its_end) as process:
        os.close(its_end)
        shown = read(terminal, until="say something")
        subprocess.run(["paplay", "--device=mic", str(GO_BACK)], env=environment, check=True)
        shown += read(terminal, until="signal to noise")
        process.wait(timeout=60)
    os.close(terminal)
    assert process.returncode == 0
    assert "━" in shown
    assert "dBFS  #" not in shown
    assert "\x1b[?25h" in shown  # the cursor is back
    assert "fine" in shown


def read(terminal: int, until: str) -> str:
    shown = b""
    while until.encode() not in shown:
        shown += os.read(terminal, 4096)
    return shown.decode()
