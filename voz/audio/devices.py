"""Which microphones there are, and which of them is meant, as PortAudio knows them."""

from __future__ import annotations

from types import ModuleType
from typing import NamedTuple

from voz.audio.portaudio import load_sounddevice
from voz.errors import AudioError


class Device(NamedTuple):
    """A microphone.

    Attributes:
        number: PortAudio's, until devices come or go.
        name: PortAudio's.
        channels: how many it has.
        rate: that of its own, Hz.
        system: the sound system that it belongs to, as ALSA or JACK.
    """

    number: int
    name: str
    channels: int
    rate: int
    system: str


def microphones() -> list[Device]:
    """List all devices that record, in the order of their numbers.

    Raises:
        AudioError: PortAudio is not installed.
    """
    sounddevice = load_sounddevice()
    systems = [system["name"] for system in sounddevice.query_hostapis()]
    return [
        Device(
            found["index"],
            found["name"],
            found["max_input_channels"],
            int(found["default_samplerate"]),
            systems[found["hostapi"]],
        )
        for found in sounddevice.query_devices()
        if found["max_input_channels"] > 0
    ]


def choose(wanted: str | None = None) -> Device:
    """Find the microphone that is meant.

    Args:
        wanted: its number, or a part of its name that no other has; None is the default one.

    Raises:
        AudioError: there is no such microphone, or there are several.
    """
    there = microphones()
    if not there:
        raise AudioError("there is no microphone; connect one and start again")
    number = _number(load_sounddevice(), wanted)
    for device in there:
        if device.number == number:
            return device
    names = ", ".join(f'{device.number} "{device.name}"' for device in there)
    lacking = (
        "no default microphone" if wanted is None else f'not exactly one microphone "{wanted}"'
    )
    raise AudioError(f"there is {lacking}; take the number of one of: {names}")


def _number(sounddevice: ModuleType, wanted: str | None) -> int | None:
    """Ask sounddevice, whose users know how it finds a name; None if it finds not one."""
    try:
        if wanted is not None and wanted.isdecimal():
            return int(wanted)
        return int(sounddevice.query_devices(wanted, "input")["index"])
    except (sounddevice.PortAudioError, ValueError):
        return None
