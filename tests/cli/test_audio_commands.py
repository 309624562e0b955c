"""`voz devices`, `voz say` and `voz sound`."""

from __future__ import annotations

import os
import pty
import signal
import subprocess
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import soundfile
from calls import VOZ, in_process
from loudspeaker import at_16_khz, best, is_silent, likeness, recording
from programs import PATIENCE
from recordings import GO_BACK

from voz.audio import SAMPLE_RATE
from voz.audio.playback import PLAYBACK_RATE
from voz.audio.recording_level import RecordingLevel
from voz.audio.sound_files import read_sound
from voz.cli.audio_commands import level_report
from voz.speech.builtin_sounds import BuiltinSound, synthesize_sound


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


def test_a_computer_without_microphone_is_one_line(no_sound: dict[str, str]) -> None:
    complaint = in_process("devices", env=no_sound).complaint
    assert complaint == "voz: there is no microphone; connect one and start again"


def test_a_device_whose_name_is_no_utf_8_is_listed(no_sound: dict[str, str]) -> None:
    name = 'pcm.micr\xf3fono { type null hint { show on description "x" } }'
    config = Path(no_sound["ALSA_CONFIG_PATH"])
    config.write_bytes(name.encode("latin-1") + b"\npcm.default { type null }")
    result = in_process("devices", env=no_sound)
    assert result.code == 0
    assert "micrófono" in result.out
    assert ">" in in_process("devices", "-d", "micrófono", env=no_sound).out


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


@pytest.mark.parametrize(
    ("background", "said"),
    [(-70.0, "about 97 of 100 commands are obeyed"), (-23.0, "will have to be said again")],
)
def test_it_says_what_the_background_means_for_commands(background: float, said: str) -> None:
    *_, figure, meaning = level_report(RecordingLevel(False, -3.0, -20.0, background, 0.0))
    assert figure.startswith("signal to noise")
    assert said in meaning


def test_where_nobody_spoke_there_is_nothing_to_say_about_the_background() -> None:
    assert (
        level_report(RecordingLevel(False, -3.0, None, -60.0, 0.0))[-1] == "signal to noise     -"
    )


NO_LOUDSPEAKER = "there is no loudspeaker; connect one"


@pytest.fixture
def no_sound(tmp_path: Path) -> dict[str, str]:
    (tmp_path / "alsa.conf").write_text("pcm.default { type hw card 99 }")
    return os.environ | {"ALSA_CONFIG_PATH": str(tmp_path / "alsa.conf")}


def test_say_writes_a_wav(voz: Any, tmp_path: Path) -> None:
    result = voz("say", "hello robot", "--out", tmp_path / "hello.wav")
    assert result.code == 0
    assert result.err == f"written: {tmp_path / 'hello.wav'}, said by kal_diphone\n"
    assert soundfile.info(tmp_path / "hello.wav").duration > 0.4


def test_say_lists_the_voices_that_are_installed(voz: Any) -> None:
    assert "kal_diphone" in voz("say", "--list-voices").out.splitlines()


@pytest.mark.slow
def test_say_is_heard(pulse: dict[str, str]) -> None:
    with recording(pulse) as recorder:
        result = in_process("say", "hello", env=pulse)
        recorder.pass_by(0.2)
        assert (result.code, result.out, result.err) == (0, "", "")
        assert not is_silent(recorder.heard())


def test_sound_lists_the_built_in_sounds(voz: Any) -> None:
    assert voz("sound", "--list").out.splitlines() == [
        "backing-up",
        "needs-unplugging",
        "needs-plugging",
        "needs-unplugging-badly",
        "needs-plugging-badly",
    ]


@pytest.mark.realtime
@pytest.mark.slow
def test_a_built_in_sound_and_a_file_are_heard(pulse: dict[str, str], tmp_path: Path) -> None:
    wave = synthesize_sound(BuiltinSound.NEEDS_PLUGGING_BADLY)
    soundfile.write(tmp_path / "own.ogg", wave, PLAYBACK_RATE)

    with recording(pulse) as recorder:

        def alike(name: object) -> float:
            before = len(recorder.heard())
            assert in_process("sound", name, "--volume", 0.5, env=pulse).code == 0
            recorder.pass_by(0.2)
            return likeness(at_16_khz(wave), recorder.heard()[before:])

        assert best(lambda: alike("needs-plugging-badly"), 0.95) > 0.95
        assert best(lambda: alike(tmp_path / "own.ogg"), 0.95) > 0.95
    assert len(read_sound(tmp_path / "own.ogg", PLAYBACK_RATE)) == len(wave)


@pytest.mark.realtime
@pytest.mark.slow
def test_a_sound_that_repeats_ends_by_ctrl_c(pulse: dict[str, str]) -> None:
    command = [*VOZ, "sound", "backing-up", "--repeat"]
    with recording(pulse) as recorder, subprocess.Popen(command, env=pulse) as program:
        while is_silent(recorder.pass_by(0.2)):
            assert program.poll() is None
        assert not is_silent(recorder.pass_by(1))
        assert not is_silent(recorder.pass_by(1))
        program.send_signal(signal.SIGINT)
        assert program.wait(timeout=PATIENCE) == 128 + signal.SIGINT
        recorder.pass_by(0.2)
        assert is_silent(recorder.pass_by(1))


@pytest.mark.parametrize(
    ("arguments", "complaint"),
    [
        (["sound"], "nothing to play"),
        (["sound", "forward-going"], "forward-going: is no file and no built-in sound; see `voz"),
        (["sound", "audio_fixtures"], "audio_fixtures: is a folder"),
        (["sound", "README.md"], "README.md: is no recording that can be read"),
        (["sound", "backing-up", "--volume", 2], "--volume"),
        (["sound", "backing-up", "--volume", "nan"], "'--volume': nan is no number"),
    ],
)
def test_a_sound_that_cannot_be_is_one_line(
    arguments: list[object], complaint: str, voz: Any
) -> None:
    assert complaint in voz(*arguments).complaint


@pytest.mark.parametrize("arguments", [["say", "hello"], ["sound", "backing-up"]])
def test_without_a_loudspeaker_it_is_an_error(
    arguments: list[str], no_sound: dict[str, str]
) -> None:
    assert in_process(*arguments, env=no_sound).complaint == f"voz: {NO_LOUDSPEAKER}"


def test_a_sound_that_repeats_waits_for_a_loudspeaker(no_sound: dict[str, str]) -> None:
    command = [*VOZ, "sound", "backing-up", "--repeat"]
    with subprocess.Popen(command, env=no_sound, stderr=subprocess.PIPE, text=True) as program:
        assert program.stderr is not None
        assert program.stderr.readline() == f"warning: {NO_LOUDSPEAKER}\n"
        program.send_signal(signal.SIGTERM)
        assert program.wait(timeout=PATIENCE) == 128 + signal.SIGTERM
        assert program.stderr.read() == ""
