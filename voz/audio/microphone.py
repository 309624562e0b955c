"""Microphones: PortAudio's devices, the sound server's sources, and blocks as they arrive."""

from __future__ import annotations

import os
import queue
import re
import subprocess
import threading
import time
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from dataclasses import dataclass
from itertools import product
from types import ModuleType
from typing import Any, NamedTuple

import numpy as np

from voz.audio import SAMPLE_RATE, Samples
from voz.audio.channels import ChannelMixer
from voz.audio.portaudio import audio_errors, load_sounddevice, open_stream
from voz.audio.sound_files import Resampler
from voz.errors import AudioError

PULSE_DEVICE = "pulse"
"""PortAudio's name of the sound server."""

SERVED_DEVICES = (PULSE_DEVICE, "default")
"""Devices by which the server chooses the source; the second is the server if one runs."""

SOURCE_VARIABLE = "PULSE_SOURCE"

ONLY_SILENCE = "the microphone gives only silence"
"""What is wrong with a muted one."""

SOURCE_REMOVED = b"'remove' on source #"
"""What `pactl subscribe` prints when a source is gone."""

PACTL_TIMEOUT = 2.0
"""Time for the server to answer, s; one that hangs never does."""

_LINE = re.compile(r"^\d+\t([^\t]+)\t.*?\b(\d+)ch (\d+)Hz", re.MULTILINE)


class PulseSource(NamedTuple):
    """A source, its number of channels and its rate, Hz."""

    name: str
    channels: int
    rate: int


def list_sources() -> list[PulseSource]:
    """The sources that `pactl` lists; none without it or without a server."""
    return [
        PulseSource(name, int(channels), int(rate))
        for name, channels, rate in _LINE.findall(_pactl("list", "short", "sources"))
    ]


def _pactl(*call: str) -> str:
    """What `pactl` prints; nothing without it or without a server."""
    try:
        done = subprocess.run(
            ["pactl", *call],
            stdin=subprocess.DEVNULL,
            capture_output=True,
            text=True,
            errors="replace",
            timeout=PACTL_TIMEOUT,
            check=True,
        )
    except (OSError, subprocess.SubprocessError):
        return ""
    return done.stdout


@contextmanager
def pulse_source_selected(source: str | None) -> Iterator[None]:
    """Let streams that are opened in a `with` block record from a source; None changes nothing."""
    if source is None:
        yield
        return
    before = os.environ.get(SOURCE_VARIABLE)
    os.environ[SOURCE_VARIABLE] = source
    try:
        yield
    finally:
        if before is None:
            del os.environ[SOURCE_VARIABLE]
        else:
            os.environ[SOURCE_VARIABLE] = before


class Device(NamedTuple):
    """A microphone."""

    number: int  # PortAudio's, until devices come or go; for a source, the sound server's
    name: str  # of the device or source
    channels: int  # their number
    rate: int  # its native rate, Hz
    system: str  # the sound system, such as ALSA or JACK
    is_source: bool = False  # whether it is one of several sources that share a number

    @property
    def handle(self) -> str:
        """The `--device` that selects it alone."""
        return self.name if self.is_source else str(self.number)

    def __str__(self) -> str:
        return f'"{self.name}"' if self.is_source else f'{self.number} "{self.name}"'


def list_microphones() -> list[Device]:
    """List PortAudio's recording devices; raises AudioError if it is not installed."""
    sounddevice = load_sounddevice()
    try:
        systems = [system["name"] for system in sounddevice.query_hostapis()]
        devices = sounddevice.query_devices()
    except audio_errors(sounddevice) as error:
        reason = " ".join(str(error).split())
        raise AudioError(f"the microphones cannot be listed ({reason})") from error
    return [
        Device(
            found["index"],
            found["name"],
            found["max_input_channels"],
            int(found["default_samplerate"]),
            systems[found["hostapi"]],
        )
        for found in devices
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
    except audio_errors(sounddevice):
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


MICROPHONE_BLOCK_SECONDS = 0.03
"""Length of a block of the sound card."""

MAX_QUEUED_BLOCKS = 170
"""5 s of blocks that wait to be taken; then the oldest are dropped."""

BLOCK_TIMEOUT = 1.0
"""A device that gives no block for this time is lost, s; even silence arrives as samples."""


@dataclass(frozen=True)
class _Settings:
    device: int
    rate: int
    channels: int


class _Arrived(NamedTuple):
    """A block, 32-bit floats of all channels, and its monotonic arrival time, s."""

    sound: bytes
    when: float


class Microphone:
    """An open microphone: an iterator over its blocks, 16 kHz, without an end.

    Blocks that are not taken are dropped, the oldest first. When it fails, AudioError is raised.

    Attributes:
        name: of the device.
        alive: monotonic time of the last callback, s.
        arrived: monotonic arrival time of the block that was taken last, s.
        blocks_lost: number of dropped blocks, of `MICROPHONE_BLOCK_SECONDS` each.
        complete, addressed, out_of_phase: see `OpenMicrophone`.
    """

    complete = True
    addressed = False

    def __init__(self, name: str, rate: int, channels: int) -> None:
        self.name = name
        self.alive = self.arrived = time.monotonic()
        self.blocks_lost = 0
        self._channels = channels
        self._waiting: queue.Queue[_Arrived | None] = queue.Queue(MAX_QUEUED_BLOCKS)
        self._mixer = ChannelMixer(rate)
        self._resampler = Resampler(rate)

    @property
    def out_of_phase(self) -> bool:
        """Whether its channels would cancel each other."""
        return self._mixer.out_of_phase

    def heard(self, block: Any, _frames: int, _time: Any, status: Any) -> None:
        """PortAudio's callback."""
        self.alive = time.monotonic()
        self.blocks_lost += bool(status.input_overflow)
        self._put(_Arrived(bytes(block), self.alive))  # PortAudio uses its block again

    def ended(self) -> None:
        """PortAudio's callback at the end of the stream."""
        self._put(None)

    def __iter__(self) -> Iterator[Samples]:
        return self

    def __next__(self) -> Samples:
        try:
            arrived = self._waiting.get(timeout=BLOCK_TIMEOUT)
        except queue.Empty:
            arrived = None
        if arrived is None:
            raise AudioError("the microphone is gone; connect it and start again")
        self.arrived = arrived.when
        channels = np.frombuffer(arrived.sound, np.float32).reshape(-1, self._channels)
        return self._resampler.feed(self._mixer.feed(channels))

    def _put(self, arrived: _Arrived | None) -> None:
        if self._waiting.full():
            self.blocks_lost += 1
            with suppress(queue.Empty):  # just then the last one was taken
                self._waiting.get_nowait()
        self._waiting.put_nowait(arrived)


SUBSCRIPTION_WAIT, SUBSCRIPTION_CHECKS = 0.1, 20
"""Until the server tells what changes, a source is looked for at most so often, so far apart, s."""


@contextmanager
def ends_with_its_source(microphone: Microphone, chosen: Device) -> Iterator[None]:
    """End a microphone in a `with` block when the source that it records from is gone.

    A sound server would go on with another one, which may be far from who speaks.
    """
    source = _source_of(chosen)
    if source is None:
        yield
        return
    call = ["pactl", "subscribe"]
    own = os.environ | {"LC_ALL": "C"}
    pipe, nothing = subprocess.PIPE, subprocess.DEVNULL
    with subprocess.Popen(call, env=own, stdin=nothing, stdout=pipe, stderr=nothing) as events:
        subscribed = threading.Event()

        def watch() -> None:
            for line in events.stdout or ():
                subscribed.set()
                if SOURCE_REMOVED in line and not _is_there(source):
                    microphone.ended()

        watching = threading.Thread(target=watch, name="voz-source", daemon=True)
        watching.start()
        try:
            for _ in range(SUBSCRIPTION_CHECKS):
                if not _is_there(source):  # the server tells of each who asks, once it tells at all
                    microphone.ended()
                    break
                if subscribed.wait(SUBSCRIPTION_WAIT) or events.poll() is not None:
                    break
            yield
        finally:
            events.kill()
            watching.join()


def _source_of(device: Device) -> str | None:
    """The source of the sound server that a device records from now; None if there is none."""
    if device.is_source:
        return device.name
    if device.name not in SERVED_DEVICES:
        return None
    usual = os.environ.get(SOURCE_VARIABLE) or _pactl("get-default-source").strip()
    return usual if usual and _is_there(usual) else None


def _is_there(source: str) -> bool:
    return any(each.name == source for each in list_sources())


@contextmanager
def open_microphone(device: str | None = None) -> Iterator[Microphone]:
    """Open a microphone for a `with` block: a number, or a part of a name; None is the default.

    Raises:
        AudioError: there is no such microphone, or it fails.
    """
    sounddevice = load_sounddevice()
    chosen = choose_microphone(device)
    settings = _settings(sounddevice, chosen)
    microphone = Microphone(chosen.name, settings.rate, settings.channels)
    try:
        with (
            ends_with_its_source(microphone, chosen),
            pulse_source_selected(chosen.name if chosen.is_source else None),
            open_stream(
                "RawInputStream",
                samplerate=settings.rate,
                blocksize=round(MICROPHONE_BLOCK_SECONDS * settings.rate),
                device=settings.device,
                channels=settings.channels,
                dtype="float32",
                latency="low",
                callback=microphone.heard,
                finished_callback=microphone.ended,
            ),
        ):
            yield microphone
    except audio_errors(sounddevice) as error:
        reason = " ".join(str(error).split())
        raise AudioError(f"the microphone fails ({reason})", "check the sound settings") from error


def _settings(sounddevice: ModuleType, device: Device) -> _Settings:
    """Return the first settings that the device accepts, 16 kHz if possible.

    In stereo if it has that: a sound server would add up channels that cancel each other.
    """
    most = min(device.channels, 2)
    for rate, channels in product((SAMPLE_RATE, device.rate), dict.fromkeys((most, 1))):
        settings = _Settings(device.number, rate, channels)
        try:
            sounddevice.check_input_settings(settings.device, channels, "float32", samplerate=rate)
        except audio_errors(sounddevice):
            continue
        return settings
    return _Settings(device.number, device.rate, device.channels)
