"""The examples do what they say, run as a user would run them."""

from __future__ import annotations

import os
import shutil
import signal
import socket
import subprocess
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from threading import Thread

import numpy as np
import pytest
import soundfile
import soxr
from calls import VOZ
from loudspeaker import Recorder
from programs import PATIENCE, wait_until
from recordings import ROOT, Recording
from synthesis import phrase, with_floor

from voz.api.recognizer import Recognizer
from voz.audio import SAMPLE_RATE
from voz.language.build import build
from voz.language.language_files import LanguageFiles
from voz.settings import Recognition

EXAMPLES = ROOT / "examples"


def run(name: str, *arguments: object, **others: object) -> list[str]:
    command = [sys.executable, str(EXAMPLES / name), *map(str, arguments)]
    done = subprocess.run(command, capture_output=True, check=True, **others)  # type: ignore[call-overload]
    return done.stdout.decode().splitlines()


@pytest.fixture
def stereo(session: Recording, tmp_path: Path) -> Path:
    """The session as a recorder with two channels at 44.1 kHz would keep it."""
    louder = soxr.resample(session.samples().astype(np.float32) / 32768, 16000, 44100)
    path = tmp_path / "stereo.wav"
    soundfile.write(path, np.stack([louder, 0.5 * louder], axis=1), 44100)
    return path


def test_a_recording_in_an_array_is_understood(stereo: Path, session: Recording) -> None:
    lines = run("decode_array.py", stereo)
    assert [" ".join(line.split()[2:-2]) for line in lines] == session.commands
    assert all(line.endswith("True") for line in lines)


def test_a_list_of_ones_own_is_understood(tmp_path: Path) -> None:
    voices = [phrase("festival_kal", text) for text in ("turn red light on", "go forward")]
    blocks = [with_floor(voice, np.random.default_rng(0)) for voice in voices]
    soundfile.write(tmp_path / "take.wav", np.concatenate(blocks), SAMPLE_RATE)
    lines = run("own_list.py", tmp_path / "take.wav")
    assert lines == ["turn red light on {'color': 'red'}", "go forward {}"]


def test_a_stream_of_ones_own_is_understood_as_it_comes(session: Recording) -> None:
    samples = soxr.resample(session.samples(), 16000, 48000).astype("<i2")
    first = samples[: 4 * 48000].tobytes()
    assert run("follow_async.py", input=first) == session.commands[:2]
    lines = run("follow_stream.py", input=samples.tobytes())
    utterances = [line for line in lines if line.startswith("<Utterance")]
    assert len(utterances) == len(session.commands)
    assert all(", accepted, " in line for line in utterances)


@pytest.mark.slow
def test_what_is_said_into_the_microphone_is_printed_and_drives(
    pulse: dict[str, str], session: Recording, tmp_path: Path
) -> None:
    samples = session.samples()[: round(8.6 * SAMPLE_RATE)]
    soundfile.write(tmp_path / "said.wav", samples, SAMPLE_RATE)
    commands, moving = session.commands[:4], {"0.1 m/s, 0 rad/s", "0.15 m/s, 0 rad/s"}
    with (
        spoken_to("drive_by_voice.py", pulse) as (driver, velocities),
        spoken_to("background.py", pulse) as (listener, in_background),
        spoken_to("microphone.py", pulse) as (printer, heard),
    ):
        wait_until(lambda: heard == in_background == ["listening"])
        said = ["paplay", "--device=mic", str(tmp_path / "said.wav")]
        subprocess.run(said, env=pulse, check=True)
        wait_until(lambda: len(heard) > len(commands))
        wait_until(lambda: len(in_background) > len(commands))
        assert listener.stdin
        listener.stdin.write("\n")
        listener.stdin.flush()
        printer.send_signal(signal.SIGINT)
        assert [each.wait(PATIENCE) for each in (listener, printer)] == [0, 0]
        # Where the machine is busy, the robot stops, and misses commands: they are said again.
        wait_until(lambda: moving & {*velocities} or subprocess.run(said, env=pulse).returncode)
        driver.send_signal(signal.SIGINT)
        assert driver.wait(PATIENCE) == 0
    assert heard[1:] == in_background[1:] == commands
    assert velocities[-1] == "0 m/s, 0 rad/s"


@contextmanager
def spoken_to(
    name: str, pulse: dict[str, str]
) -> Iterator[tuple[subprocess.Popen[str], list[str]]]:
    """An example that hears a microphone, and the lines that it prints."""
    lines: list[str] = []
    command = [sys.executable, str(EXAMPLES / name)]
    pipe = subprocess.PIPE
    with subprocess.Popen(command, env=pulse, stdin=pipe, stdout=pipe, text=True) as process:
        assert process.stdout
        reader = Thread(
            target=lambda out: lines.extend(map(str.strip, out)), args=(process.stdout,)
        )
        reader.start()
        try:
            yield process, lines
        finally:
            process.kill()
            reader.join()


def test_a_loop_of_ones_own_drives(stereo: Path) -> None:
    lines = run("drive_loop.py", stereo)
    assert lines[0] == "0.1 s: 0 m/s, 0 rad/s"
    assert any(line.endswith("0.1 m/s, 0 rad/s") for line in lines)
    assert lines[-1].endswith("0 m/s, 0 rad/s")


def test_a_robot_of_ones_own_receives_what_is_obeyed(tmp_path: Path) -> None:
    # A velocity that a busy robot has not taken yet gives way to the next: let time pass.
    (tmp_path / "said.txt").write_text("go forward\n-\n-\n-\nstop\n")
    command = [*VOZ, "run", "--listening", "--robot", "my_robot:Lamp", "--text", "said.txt"]
    done = subprocess.run(
        [*command, "--no-sound"],
        cwd=tmp_path,
        env={"PATH": "/usr/bin:/bin", "PYTHONPATH": f"{EXAMPLES}:{ROOT}", "HOME": str(tmp_path)},
        capture_output=True,
        text=True,
        check=True,
    )
    lines = done.stdout.splitlines()
    assert lines[:2] == ["obeyed: go forward", "lamp on"], done.stderr
    # A zero overtakes what a busy robot has not taken yet.
    assert sorted(lines[2:]) == ["lamp off", "obeyed: stop"], done.stderr


def run_tcp_robot(folder: Path, port: int) -> subprocess.CompletedProcess[str]:
    (folder / "said.txt").write_text("go forward\n-\n-\n-\nstop\n")
    (folder / "voz.toml").write_text(f'[own.tcp_robot]\nhost = "127.0.0.1"\nport = {port}\n')
    command = [*VOZ, "run", "--listening", "--robot", "tcp_robot:TcpRobot", "--text", "said.txt"]
    environment = os.environ | {"PYTHONPATH": f"{EXAMPLES}:{ROOT}"}
    return subprocess.run(
        [*command, "--no-sound"], cwd=folder, env=environment, capture_output=True, text=True
    )


def test_a_robot_on_a_tcp_socket_gets_velocities_and_commands_and_zero_at_the_end(
    tmp_path: Path,
) -> None:
    with socket.create_server(("127.0.0.1", 0)) as server:
        server.settimeout(PATIENCE)
        lines: list[str] = []

        def serve() -> None:
            robot, _ = server.accept()
            with robot, robot.makefile() as received:
                lines.extend(map(str.strip, received))

        thread = Thread(target=serve)
        thread.start()
        done = run_tcp_robot(tmp_path, server.getsockname()[1])
        thread.join()
    assert (done.returncode, done.stderr) == (0, "settings: voz.toml\n")
    assert {"c go forward", "v 0.10 0.00", "c stop"} <= {*lines}
    assert lines[-1] == "v 0.00 0.00"
    failed = run_tcp_robot(tmp_path, 1)  # where nobody listens
    assert failed.returncode == 2
    assert "no robot at 127.0.0.1:1 (" in failed.stderr


def read_by_nobody(name: str, *arguments: object, sound: bytes = b"") -> tuple[int, bytes]:
    """How an example ends whose output nobody reads, and what it says of that."""
    unread, written = os.pipe()
    os.close(unread)
    command = [sys.executable, str(EXAMPLES / name), *map(str, arguments)]
    done = subprocess.run(
        command,
        input=sound,
        stdout=written,
        stderr=subprocess.PIPE,
        # ALSA's plugin for PulseAudio blocks it here once PortAudio was loaded; no shell does.
        preexec_fn=lambda: signal.pthread_sigmask(signal.SIG_UNBLOCK, [signal.SIGPIPE]),
    )
    os.close(written)
    return done.returncode, done.stderr


def test_an_example_whose_output_nobody_reads_ends_without_a_word(
    stereo: Path, session: Recording, tmp_path: Path
) -> None:
    samples = soxr.resample(session.samples(), 16000, 48000).astype("<i2")
    by_signal = (-signal.SIGPIPE, b"")
    assert read_by_nobody("follow_stream.py", sound=samples.tobytes()) == by_signal
    assert read_by_nobody("decode_array.py", stereo) == by_signal
    sound, rate = soundfile.read(stereo)
    soundfile.write(tmp_path / "long.wav", np.concatenate([sound] * 4), rate)
    assert read_by_nobody("drive_loop.py", tmp_path / "long.wav") == (0, b"")


def test_a_stream_that_is_ended_by_ctrl_c_or_in_the_midst_of_a_sample_ends_without_a_word() -> None:
    assert run("follow_stream.py", input=bytes(9601)) == []
    command = [sys.executable, str(EXAMPLES / "follow_stream.py")]
    with subprocess.Popen(command, stdin=subprocess.PIPE, stderr=subprocess.PIPE) as process:
        assert process.stdin
        assert process.stderr
        process.stdin.write(bytes(2_000_000))  # more than fits into the pipe: it reads
        process.send_signal(signal.SIGINT)
        assert process.wait(60) == -signal.SIGINT
        assert process.stderr.read() == b""


@pytest.mark.parametrize("mistake", ["OSError('the cable is out')", "KeyboardInterrupt"])
def test_a_loop_of_ones_own_that_fails_stops_the_robot(mistake: str, stereo: Path) -> None:
    program = (
        "import runpy, sys, voz\n"
        "class Failing(voz.Controller):\n"
        "    def send(self, t):\n"
        "        super().send(t)\n"
        f"        if t > 4: raise {mistake}\n"
        "voz.Controller = Failing\n"
        f"runpy.run_path({str(EXAMPLES / 'drive_loop.py')!r})\n"
    )
    done = subprocess.run([sys.executable, "-c", program, stereo], capture_output=True, text=True)
    assert done.returncode
    *_, before, last = done.stdout.splitlines()
    assert before.startswith("4.1 s: ")
    assert last == "4.1 s: 0 m/s, 0 rad/s"


@pytest.mark.slow
def test_sounds_are_played_and_texts_said(loudspeaker: Recorder) -> None:
    assert run("robot_sounds.py") == []
    heard = np.abs(loudspeaker.heard())
    assert heard.max() > 0.05
    assert np.count_nonzero(heard > 0.01) > 8000


def test_each_example_says_how_it_is_called() -> None:
    for path in EXAMPLES.glob("*.py"):
        first = path.read_text(encoding="utf-8").removeprefix("#!/usr/bin/env python3\n")
        assert path.stem in first.split('"""')[1]


def drive(example: str, robot: str, folder: Path, *lines: str) -> list[str]:
    """Build the list of an example, drive its robot by typed lines, and give what it printed."""
    here = EXAMPLES / example
    for file in here.iterdir():
        (folder / file.name).write_bytes(file.read_bytes())
    build = [*VOZ, "build-lm", "commands.txt", "--out", "lm"]
    subprocess.run(build, cwd=folder, check=True, capture_output=True)
    (folder / "said.txt").write_text("\n".join(["start speech", *lines]) + "\n")
    run = [*VOZ, "run", "--no-sound", "--robot", robot, "--text", "said.txt"]
    done = subprocess.run(run, cwd=folder, check=True, capture_output=True, text=True)
    assert len((here / f"{example}.py").read_text().splitlines()) <= 40
    return done.stdout.splitlines()


@pytest.mark.realtime
def test_an_arm_brings_what_was_said_and_asks_before_it_folds(tmp_path: Path) -> None:
    said = ["bring me the deep blue cup", "give me the water bottle", "open the gripper"]
    printed = drive("arm", "arm:Arm,console", tmp_path, *said, "fold the arm", "no", "stop")
    own = [line for line in printed if " s  " not in line]
    assert own == ["reach blue cup at (0.3, 0.1)", "reach any water at (0.1, 0.3)", "gripper open"]
    told = "\n".join(printed)
    assert 'robot says "I bring the water"' in told
    assert 'robot says "shall I fold?"' in told
    assert "I fold the arm" not in told


@pytest.mark.realtime
def test_a_drone_flies_as_far_as_was_said_and_never_on(tmp_path: Path) -> None:
    said = ["take off", "climb 2 metres", "fly backward one metre", *"-" * 25]
    said += ["turn left 90 degrees", *"-" * 35, "fly forward ten metres", "-", "hover"]
    printed = drive("drone", "drone:Drone", tmp_path, *said)
    assert printed == [
        "height 1 m",
        "height 3 m",
        "fly at -0.5 m/s, turn at 0 rad/s",
        "fly at 0 m/s, turn at 0 rad/s",
        "fly at 0 m/s, turn at 0.5 rad/s",
        "fly at 0 m/s, turn at 0 rad/s",
        "fly at 0.5 m/s, turn at 0 rad/s",
        "fly at 0 m/s, turn at 0 rad/s",
    ]


def test_the_drone_hears_both_ways_to_make_it_hold_its_position(tmp_path: Path) -> None:
    build(EXAMPLES / "drone" / "commands.txt", tmp_path)
    recognizer = Recognizer(LanguageFiles(tmp_path), Recognition())
    voices = ["festival_kal", "festival_ked", "flite_awb", "flite_rms", "espeak_us"]
    said = [(voice, "hover") for voice in voices]
    said += [(voice, "hold position") for voice in [*voices, "espeak_gb"]]
    for voice, text in said:
        sound = with_floor(phrase(voice, text), np.random.default_rng(0))
        heard = recognizer.decode(sound.astype(np.float32), SAMPLE_RATE)
        found = [(u.text, u.command) for u in heard if u.accepted]
        assert found == [(text, "stop")], (voice, text)


def test_the_spanish_example_is_obeyed(tmp_path: Path) -> None:
    shutil.copytree(EXAMPLES / "spanish", tmp_path, dirs_exist_ok=True)
    (tmp_path / "said.txt").write_text("avanza\npara\nsaluda\n", encoding="utf-8")
    subprocess.run([*VOZ, "build-lm", "comandos.txt", "--out", "lm"], cwd=tmp_path, check=True)
    run = [*VOZ, "run", "--no-sound", "--listening", "--text", "said.txt"]
    done = subprocess.run(run, cwd=tmp_path, check=True, capture_output=True, text=True)
    told = [line.split(maxsplit=2)[2] for line in done.stdout.splitlines()]
    assert told[1::2] == [
        "el robot avanza a 0.10 m/s",
        "el robot está parado",
        "el robot dice «hola, ¿qué tal?»",
    ]
