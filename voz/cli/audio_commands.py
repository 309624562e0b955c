"""`voz devices`, `voz say` and `voz sound`: the microphone and the loudspeaker."""

from __future__ import annotations

import threading
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from shutil import which
from typing import TYPE_CHECKING, Annotated

import typer

from voz.cli.options import DeviceOption, finite
from voz.cli.text_io import info, show, warn
from voz.errors import AudioError, SpeechError

if TYPE_CHECKING:
    from rich.console import Console

    from voz.audio import Samples
    from voz.audio.microphone import Device
    from voz.audio.recording_level import RecordingLevel
    from voz.speech.sound_client import SoundClient

RECORDING_SECONDS = 3
"""Time for a command, and for a pause that shows the background level."""


def devices(
    device: DeviceOption = None,
    test: Annotated[
        bool, typer.Option("--test", help="Record three seconds, and tell what is wrong with them.")
    ] = False,
) -> None:
    """Show the microphones and which one is used, or test it.

    Every command with --device takes its number or a part of its name. What has no number is a
    source of PulseAudio or PipeWire, as `pactl list short sources` names it.

    Example: voz devices --test
    """
    from voz.audio.microphone import (
        choose_microphone,
        list_microphones,
        list_pulse_microphones,
    )

    used = choose_microphone(device)
    if test:
        try_microphone(used)
    else:
        there = list_microphones()
        show(*_device_table([*there, *list_pulse_microphones(there)], used))
        show("> is used; take another with --device N or --device NAME (a part of it is enough)")


def _number(device: Device) -> str:
    return "" if device.is_source else str(device.number)


def _device_table(there: list[Device], used: Device) -> list[str]:
    """Mark what is used as sounddevice does."""
    width = max(len(device.name) for device in there)
    return [
        f"     {'name':{width}}  channels      rate  system",
        *(
            f"{'>' if device == used else ' '} {_number(device):>2} {device.name:{width}}  "
            f"{device.channels:8}  {device.rate:5} Hz  {device.system}"
            for device in there
        ),
    ]


def try_microphone(device: Device) -> None:
    """Record somebody who speaks; show the level, faults and what to do. Raises AudioError."""
    from rich.console import Console

    from voz.audio.channels import OUT_OF_PHASE
    from voz.audio.microphone import open_microphone
    from voz.audio.recording_level import measure_level

    console = Console()
    with open_microphone(device.handle) as blocks:
        first = next(blocks)  # opening a device takes its time
        show(
            f'{device}: say something now, as "go forward"; '
            f"it records for {RECORDING_SECONDS} seconds"
        )
        samples = _recorded(first, blocks, console)
        warn(f"microphone: {OUT_OF_PHASE}" if blocks.out_of_phase else None)
    show(*level_report(measure_level(samples)))


def level_report(level: RecordingLevel) -> list[str]:
    """Write what is wrong and what to do, then the figures."""
    from voz.audio.recording_level import find_faults

    lines = []
    for fault in find_faults(level):
        lines += [fault.words, f"  {fault.advice}"]
    lines = lines or ["fine: the speech is loud enough and clear"]
    figures = {
        "peak": (level.peak, "dBFS"),
        "speech": (level.speech, "dBFS"),
        "background": (level.background, "dBFS"),
        "signal to noise": (level.above_background, "dB"),
    }
    for name, (figure, unit) in figures.items():
        lines.append(f"{name:16}" + ("    -" if figure is None else f"{figure:5.0f} {unit}"))
    if level.above_background is not None:
        lines.append(f"  {_meaning(level.above_background)}")
    return lines


def _meaning(above: float) -> str:
    """Explain in words a level so far above the background, dB."""
    from voz.audio.recording_level import obeyed_of_100

    share = obeyed_of_100(above)
    if share is None:
        return "many commands will have to be said again"
    return f"about {share} of 100 commands are obeyed in a sound like this that goes on"


def _recorded(first: Samples, blocks: Iterator[Samples], console: Console) -> Samples:
    """Record, and show the level meanwhile."""
    import numpy as np

    from voz.audio import SAMPLE_RATE
    from voz.terminal.level_bar import level_bar, level_line

    samples_per_line = SAMPLE_RATE // 2  # where no bar can move
    heard = first
    with level_bar(console) as show_level:
        while len(heard) < RECORDING_SECONDS * SAMPLE_RATE:
            block = next(blocks)
            show_level(block)
            lines = len(heard) // samples_per_line
            heard = np.concatenate([heard, block])
            if not console.is_terminal and len(heard) // samples_per_line > lines:
                show(level_line(heard[-samples_per_line:]))
    return heard[: RECORDING_SECONDS * SAMPLE_RATE]


def say(
    text: Annotated[str | None, typer.Argument(metavar="TEXT", help="What to say.")] = None,
    voice: Annotated[str, typer.Option(metavar="NAME", help="Who says it.")] = "kal_diphone",
    out: Annotated[
        Path | None, typer.Option(metavar="FILE.wav", help="Write it instead of playing it.")
    ] = None,
    list_voices: Annotated[
        bool, typer.Option("--list-voices", help="Show the voices that are installed.")
    ] = False,
) -> None:
    """Say a text with festival, or by a voice of espeak-ng, as espeak-ng:es.

    Example: voz say "bep bep. I am listening you" --out hello.wav
    """
    from voz.speech import synthesis

    if list_voices:
        show(*synthesis.installed_voices())
        if which("espeak-ng"):
            show("espeak-ng:en, espeak-ng:es, ... (see `espeak-ng --voices`)")
    elif text is None:
        raise SpeechError("there is nothing to say; give a text in quotes, see --help")
    elif out:
        synthesis.render(text, voice, out)
        info(f"written: {out}, said by {voice}")
    else:
        with sound_client() as client:
            client.say(text, voice, blocking=True)


@contextmanager
def sound_client(patient: bool = False) -> Iterator[SoundClient]:
    """Yield a client; a missing loudspeaker is an error, unless `patient` waits for one."""
    from voz.process.standard_streams import quiet_libraries
    from voz.speech.sound_client import SoundClient

    problems: list[str] = []
    with quiet_libraries(), SoundClient(warn=warn if patient else problems.append) as client:
        yield client
    if problems:
        raise AudioError(problems[0])


def sound(
    name: Annotated[
        str | None, typer.Argument(metavar="NAME|FILE", help="A built-in sound, or a file.")
    ] = None,
    repeat: Annotated[
        bool, typer.Option("--repeat", help="Play it again and again, until Ctrl-C.")
    ] = False,
    volume: Annotated[
        float, typer.Option(metavar="X", min=0.0, max=1.0, callback=finite, help="How loud.")
    ] = 1.0,
    list_sounds: Annotated[
        bool, typer.Option("--list", help="Show the names of the built-in sounds.")
    ] = False,
) -> None:
    """Play a built-in sound or a WAV, FLAC or OGG file.

    Example: voz sound backing-up --volume 0.5
    """
    from voz.speech.builtin_sounds import BuiltinSound

    builtin = {each.title: each for each in BuiltinSound}
    if list_sounds:
        show(*builtin)
        return
    if name is None:
        raise AudioError("there is nothing to play; give a file or a name from `voz sound --list`")
    if name not in builtin and not Path(name).exists():
        raise AudioError(f"{name}: is no file and no built-in sound; see `voz sound --list`")
    with sound_client(patient=repeat) as client:
        played = (
            client.builtin_sound(builtin[name], volume)
            if name in builtin
            else client.wave_sound(name, volume)
        )
        if repeat:
            played.repeat()
            threading.Event().wait()
        played.play(blocking=True)
