"""`voz devices`: the microphones, and how good one is."""

from __future__ import annotations

from typing import TYPE_CHECKING, Annotated

import typer

from voz.cli.options import DeviceOption
from voz.cli.text_io import show

if TYPE_CHECKING:
    from voz.audio.capture.input_devices import Device


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
    from voz.audio.capture.input_devices import (
        choose_microphone,
        list_microphones,
        list_pulse_microphones,
    )

    used = choose_microphone(device)
    if test:
        from voz.cli.try_microphone import try_microphone

        try_microphone(used)
    else:
        there = list_microphones()
        show(*_table([*there, *list_pulse_microphones(there)], used))
        show("> is used; take another with --device N or --device NAME (a part of it is enough)")


def _number(device: Device) -> str:
    return "" if device.is_source else str(device.number)


def _table(there: list[Device], used: Device) -> list[str]:
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
