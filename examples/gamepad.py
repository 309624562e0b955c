"""A gamepad beside the voice: python examples/gamepad.py | voz run --robot NAME.

Each button types a command into `voz run`, where all its rules hold. The cross drives while it is
held. `jstest /dev/input/js0` shows the numbers of your gamepad; another device is an argument.
"""

import struct
import sys
from pathlib import Path

DEVICE = Path("/dev/input/js0")

EVENT = struct.Struct("IhBB")  # ms, value, kind and number, as in linux/joystick.h
BUTTON, AXIS = 1, 2  # kinds; those with 128 more only say how it stands at the start

BUTTONS = {0: "stop", 1: "stop speech", 3: "start speech"}
AXES = {6: ("turn left", "turn right"), 7: ("go forward", "go back")}  # the cross


def command(value: int, kind: int, number: int) -> str | None:
    """Return what an event of the gamepad types."""
    if kind == BUTTON and value:
        return BUTTONS.get(number)
    if kind == AXIS and number in AXES:
        return AXES[number][value > 0] if value else "stop"
    return None


try:
    with (Path(sys.argv[1]) if sys.argv[1:] else DEVICE).open("rb") as gamepad:
        while event := gamepad.read(EVENT.size):
            _, *pressed = EVENT.unpack(event)
            if line := command(*pressed):
                print(line, flush=True)
finally:  # also when the gamepad is gone
    print("stop", flush=True)
