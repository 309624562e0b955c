"""Lists and chooses microphones: PortAudio's devices, and the sound server's sources."""

from __future__ import annotations

import re
from typing import NamedTuple

from voz.audio.capture.pulse import PULSE_DEVICE, list_sources
from voz.audio.portaudio import load_sounddevice
from voz.errors import AudioError


class Device(NamedTuple):
    """A microphone.

    Attributes:
        number: PortAudio's, until devices come or go; for a source, the sound server's.
        name: of the device or source.
        channels: their number.
        rate: its native rate, Hz.
        system: the sound system, such as ALSA or JACK.
        is_source: whether it is one of several sources that share a number.
    """

    number: int
    name: str
    channels: int
    rate: int
    system: str
    is_source: bool = False

    @property
    def handle(self) -> str:
        """The `--device` that selects it alone."""
        return self.name if self.is_source else str(self.number)

    def __str__(self) -> str:
        return f'"{self.name}"' if self.is_source else f'{self.number} "{self.name}"'


def list_microphones() -> list[Device]:
    """List PortAudio's recording devices; raises AudioError if it is not installed."""
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


def list_pulse_microphones(there: list[Device]) -> list[Device]:
    """List the sources of PulseAudio or PipeWire, if its server is among the devices."""
    return [
        Device(server.number, *source, "PulseAudio", is_source=True)
        for server in there
        if server.name == PULSE_DEVICE
        for source in list_sources()
    ]


def choose_microphone(wanted: str | None = None, without: str = " and start again") -> Device:
    """Find the microphone that the user means.

    Args:
        wanted: its number or a unique part of its name; None is the default one. Sources are
            searched if no device has the name.
        without: what the message advises besides connecting one, if there is none.

    Raises:
        AudioError: there is no such microphone, or there are several.
    """
    there = list_microphones()
    if not there:
        raise AudioError(f"there is no microphone; connect one{without}")
    meant = _default_microphone(there) if wanted is None else _matching(wanted, there)
    if wanted is not None and not meant:
        more = list_pulse_microphones(there)
        there, meant = there + more, _matching(wanted, more)
    if len(meant) == 1:
        return meant[0]
    names = ", ".join(map(str, meant or there))
    lacking = "there are several microphones" if meant else "there is no microphone"
    named = "there is no default microphone" if wanted is None else f'{lacking} "{wanted}"'
    raise AudioError(named, f"take the number or the name of one of: {names}")


def _default_microphone(there: list[Device]) -> list[Device]:
    sounddevice = load_sounddevice()
    try:
        number = sounddevice.query_devices(None, "input")["index"]
    except (sounddevice.PortAudioError, ValueError):
        return []
    return [device for device in there if device.number == number]


def _matching(wanted: str, there: list[Device]) -> list[Device]:
    """Match words in order, as sounddevice does, which does not list several matches."""
    if wanted.isdecimal():
        return [device for device in there if device.handle == wanted]
    words = re.compile(".*".join(map(re.escape, wanted.lower().split())))
    full = {device: f"{device.name}, {device.system}".lower() for device in there}
    exact = [d for d in there if wanted.lower() in (d.name.lower(), full[d])]
    return exact if len(exact) == 1 else [d for d in there if words.search(full[d])]
