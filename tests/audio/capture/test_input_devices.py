"""Which microphone is meant; each call in a new process, where PortAudio looks for devices anew."""

from __future__ import annotations

import json
import subprocess
import sys
from pathlib import Path

import pytest

from voz.audio.capture.input_devices import Device

CHOOSE = """
import json, sys
from voz.audio.capture.input_devices import choose_microphone, list_microphones
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


def test_a_computer_without_microphone_has_none_by_any_name(no_sound: dict[str, str]) -> None:
    there, errors = choose(no_sound, None, "0", "mic")
    assert there == []
    assert set(errors) == {"there is no microphone; connect one and start again"}
