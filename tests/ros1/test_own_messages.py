"""The message sound_play/SoundRequest of our own, and the node that plays it."""

from __future__ import annotations

import subprocess

from recordings import ROOT

ROS_PYTHON = ROOT / "ros" / "python"


def test_its_md5_is_that_of_sound_plays_definition() -> None:
    program = (
        "from voz.ros1.own_messages import sound_request\n"
        "kind = sound_request()\n"
        "print(kind._type, kind._md5sum, *kind.__slots__, *kind._slot_types)"
    )
    done = subprocess.run(
        [ROS_PYTHON, "-c", program], capture_output=True, text=True, check=True, timeout=60
    )
    assert done.stdout.split() == [
        "sound_play/SoundRequest",
        "d098ce4a040686259137ece23a625167",
        *("sound", "command", "volume", "arg", "arg2"),
        *("int8", "int8", "float32", "string", "string"),
    ]
