"""The work of `voz devices --test`; see `devices_command.py`."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
from rich.console import Console

from voz.audio import SAMPLE_RATE, Samples
from voz.audio.capture.input_devices import Device
from voz.audio.capture.microphone import open_microphone
from voz.audio.recording_level import RecordingLevel, find_faults, measure_level, obeyed_of_100
from voz.cli.text_io import show as show_line
from voz.terminal.level_bar import level_bar, level_line

RECORDING_SECONDS = 3
"""Time for a command, and for a pause that shows the background level."""

SAMPLES_PER_LINE = SAMPLE_RATE // 2
"""Samples from one line to the next where no bar can move."""


def try_microphone(device: Device) -> None:
    """Record somebody who speaks; show the level, faults and what to do. Raises AudioError."""
    console = Console()
    with open_microphone(device.handle) as blocks:
        first = next(blocks)  # opening a device takes its time
        show_line(
            f'{device}: say something now, as "go forward"; '
            f"it records for {RECORDING_SECONDS} seconds"
        )
        samples = _recorded(first, blocks, console)
    show_line(*report(measure_level(samples)))


def report(level: RecordingLevel) -> list[str]:
    """Write what is wrong and what to do, then the figures."""
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
    share = obeyed_of_100(above)
    if share is None:
        return "many commands will have to be said again"
    return f"about {share} of 100 commands are obeyed in a sound like this that goes on"


def _recorded(first: Samples, blocks: Iterator[Samples], console: Console) -> Samples:
    """Record, and show the level meanwhile."""
    heard = first
    with level_bar(console) as show:
        while len(heard) < RECORDING_SECONDS * SAMPLE_RATE:
            block = next(blocks)
            show(block)
            lines = len(heard) // SAMPLES_PER_LINE
            heard = np.concatenate([heard, block])
            if not console.is_terminal and len(heard) // SAMPLES_PER_LINE > lines:
                show_line(level_line(heard[-SAMPLES_PER_LINE:]))
    return heard[: RECORDING_SECONDS * SAMPLE_RATE]
