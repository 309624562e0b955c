"""Which microphone is meant; each call in a new process, where PortAudio looks for devices anew."""

from __future__ import annotations

import ctypes.util
import json
import subprocess
import sys
from pathlib import Path
from shutil import which
from types import SimpleNamespace

import numpy as np
import pytest
import soundfile
from pulseaudio import pactl

from voz.audio.microphone import Device, Microphone, open_microphone
from voz.errors import AudioError

NO_OVERFLOW = SimpleNamespace(input_overflow=False)

LISTEN = """
import sys
import numpy as np
from voz.audio.microphone import open_microphone
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
def test_a_microphone_that_is_taken_away_is_one_line(
    own_pulse: tuple[dict[str, str], subprocess.Popen[bytes]], tmp_path: Path
) -> None:
    environment, server = own_pulse
    process = listen(environment, tmp_path / "heard.raw", seconds=60)
    assert process.stdout is not None
    assert process.stdout.readline() == "listening\n"
    server.kill()
    assert error_of(process) in ("the microphone is gone; connect it and start again\n",)


@pytest.mark.slow
@pytest.mark.parametrize("device", ["", "headset"])
def test_a_source_that_is_taken_away_ends_it_though_the_server_has_another_one(
    device: str, own_pulse: tuple[dict[str, str], subprocess.Popen[bytes]], tmp_path: Path
) -> None:
    environment, _ = own_pulse
    # What the server changes while one is about to be told of it must not be missed.
    slow = tmp_path / "pactl"
    slow.write_text(f'#!/bin/sh\n[ "$1" = subscribe ] && sleep 1\nexec {which("pactl")} "$@"\n')
    slow.chmod(0o755)
    environment = {**environment, "PATH": f"{tmp_path}:{environment['PATH']}"}
    headset = pactl(
        environment, "load-module module-remap-source master=mic.monitor source_name=headset"
    )
    pactl(environment, "set-default-source headset")
    process = listen(environment, tmp_path / "heard.raw", device=device, seconds=60)
    assert process.stdout is not None
    assert process.stdout.readline() == "listening\n"
    pactl(environment, f"unload-module {headset}")
    assert error_of(process) == "the microphone is gone; connect it and start again\n"


def test_missing_portaudio_gives_the_line_to_install_it(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.delitem(sys.modules, "sounddevice", raising=False)
    monkeypatch.setattr(ctypes.util, "find_library", lambda name: None)
    with pytest.raises(AudioError, match=r"libportaudio2$"), open_microphone():
        pass


CHOOSE = """
import json, sys
from voz.audio.microphone import choose_microphone, list_microphones
from voz.errors import AudioError
print(json.dumps(list_microphones()))
for wanted in json.loads(sys.argv[1]):
    try:
        print(json.dumps(choose_microphone(wanted)))
    except AudioError as error:
        print(json.dumps(str(error)))
"""

ALIKE = ("usb_desk_left", "usb_desk_right", "headset")

HANGING = """
import os, signal, sounddevice
os.kill({server}, signal.SIGSTOP)
"""

NO_DEFAULT = """
import sounddevice
sounddevice.default.device = -1
"""


def choose(
    environment: dict[str, str], *wanted: str | None, before: str = ""
) -> tuple[list[Device], list[Device | str]]:
    """What there is, and for each wish the device or the error."""
    command = [sys.executable, "-c", before + CHOOSE, json.dumps(wanted)]
    done = subprocess.run(command, env=environment, capture_output=True, text=True, check=True)
    there, *chosen = [json.loads(line) for line in done.stdout.splitlines()]
    return [Device(*d) for d in there], [c if isinstance(c, str) else Device(*c) for c in chosen]


@pytest.mark.slow
def test_a_microphone_is_meant_by_its_number_or_by_a_part_of_its_name(
    pulse: dict[str, str],
) -> None:
    there, chosen = choose(pulse, None, "0", "1", "PULSE", "puls", "pulse, alsa", "default")
    first, second = there
    assert (first.name, second.name) == ("pulse", "default")
    assert [d.number for d in there] == [0, 1]
    assert not any(d.is_source for d in there)
    assert all(d.channels > 0 and d.rate > 0 and d.system == "ALSA" for d in there)
    assert chosen == [second, first, second, first, first, first, second]


@pytest.mark.slow
def test_what_is_none_or_several_is_one_line_with_those_that_there_are(
    pulse: dict[str, str],
) -> None:
    names = 'take the number or the name of one of: 0 "pulse", 1 "default"'
    sources = '"mic.monitor", "speaker.monitor"'
    wanted = ["nobody", "2", "-1", "9" * 5000]
    _, errors = choose(pulse, *wanted)
    assert errors == [f'there is no microphone "{w}"; {names}, {sources}' for w in wanted]
    _, errors = choose(pulse, "ul", "", "alsa")
    assert errors == [f'there are several microphones "{w}"; {names}' for w in ("ul", "", "alsa")]
    _, errors = choose(pulse, None, before=NO_DEFAULT)
    assert errors == [f"there is no default microphone; {names}"]


@pytest.mark.slow
def test_of_several_only_those_that_match_are_listed(pulse: dict[str, str], tmp_path: Path) -> None:
    config = tmp_path / "alsa.conf"
    config.write_text("".join(f"pcm.{name} {{ type pulse }}\n" for name in ALIKE))
    environment = pulse | {"ALSA_CONFIG_PATH": f"/usr/share/alsa/alsa.conf:{config}"}
    there, errors = choose(environment, "usb", "desk")
    print(there)
    both = ", ".join(f'{d.number} "{d.name}"' for d in there if d.name.startswith("usb"))
    assert errors == [
        f'there are several microphones "usb"; take the number or the name of one of: {both}',
        f'there are several microphones "desk"; take the number or the name of one of: {both}',
    ]


@pytest.mark.slow
def test_a_source_of_the_sound_server_is_meant_by_a_part_of_its_name_too(
    pulse: dict[str, str], tmp_path: Path
) -> None:
    there, chosen = choose(pulse, "mic.monitor", "SPEAKER", "monitor")
    (mic, speaker, several) = chosen
    assert mic == Device(there[0].number, "mic.monitor", 1, 16000, "PulseAudio", is_source=True)
    assert isinstance(speaker, Device)
    assert speaker.name == "speaker.monitor"
    assert several == (
        'there are several microphones "monitor"; take the number or the name of one of: '
        '"mic.monitor", "speaker.monitor"'
    )
    # Those that PortAudio names itself come first.
    config = tmp_path / "alsa.conf"
    config.write_text("pcm.my_monitor { type pulse }")
    environment = pulse | {"ALSA_CONFIG_PATH": f"/usr/share/alsa/alsa.conf:{config}"}
    _, (first,) = choose(environment, "monitor")
    assert isinstance(first, Device)
    assert (first.name, first.is_source) == ("my_monitor", False)


@pytest.mark.slow
def test_without_pactl_or_an_answer_of_the_server_there_are_no_sources(
    own_pulse: tuple[dict[str, str], subprocess.Popen[bytes]], tmp_path: Path
) -> None:
    environment, server = own_pulse
    error = (
        'there is no microphone "mic.monitor"; take the number or the name of one of: '
        '0 "pulse", 1 "default"'
    )
    _, errors = choose(environment | {"PATH": str(tmp_path)}, "mic.monitor")
    assert errors == [error]
    _, errors = choose(environment, "mic.monitor", before=HANGING.format(server=server.pid))
    assert errors == [error]


def test_channels_out_of_phase_are_heard() -> None:
    tone = (0.3 * np.sin(np.arange(48_000) / 20)).astype(np.float32)
    microphone = Microphone("headset", 48_000, 2)
    heard = []
    for block in np.split(np.stack([tone, -tone], axis=1), 100):
        microphone.heard(block.tobytes(), len(block), None, NO_OVERFLOW)
        heard.append(next(microphone))
    assert microphone.out_of_phase
    assert np.abs(np.concatenate(heard)[2000:]).max() == pytest.approx(0.3 * 32768, rel=0.02)


def test_a_computer_without_microphone_has_none_by_any_name(no_sound: dict[str, str]) -> None:
    there, errors = choose(no_sound, None, "0", "mic")
    assert there == []
    assert set(errors) == {"there is no microphone; connect one and start again"}
