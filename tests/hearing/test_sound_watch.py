"""Silence and sound that is lost, as they are told."""

from __future__ import annotations

import numpy as np

from voz.audio.microphone import MICROPHONE_BLOCK_SECONDS
from voz.events import Notice
from voz.hearing.sound_watch import (
    LOSS_WARNING_INTERVAL,
    MUTE_WARNING,
    MUTED_AFTER,
    ONLY_SILENCE,
    SilenceCheck,
    SoundWatch,
)
from voz.inbox import Inbox

SECOND = np.zeros(16000, np.int16)


def warnings(inbox: Inbox) -> list[str]:
    """What was told since the last look."""
    told = []
    while (message := inbox.take(0)) is not None:
        assert isinstance(message, Notice)
        told.append(message.text)
    return told


def test_silence_matters_from_a_motion_on_until_something_is_heard() -> None:
    silence = SilenceCheck()
    looks = [  # whether it is silent, whether the robot moves, what is told
        (True, False, None),
        (False, True, None),
        (True, True, ONLY_SILENCE),
        (True, False, ONLY_SILENCE),  # nobody could have stopped it
        (False, False, None),
        (True, False, None),
    ]
    assert [silence.trouble(*look) for *look, _ in looks] == [told for *_, told in looks]


def test_a_microphone_that_is_muted_is_told_once_until_something_is_heard() -> None:
    inbox = Inbox(["stop"])
    watch = SoundWatch(inbox, lambda: 0.0)
    for _ in range(2 * int(MUTED_AFTER)):
        assert watch.check(SECOND, 0) == 0.0
    assert watch.zeros == 2 * MUTED_AFTER
    assert warnings(inbox) == [MUTE_WARNING]
    assert watch.check(SECOND - 16384, 0) == 0.5
    assert watch.zeros == 0.0
    for _ in range(int(MUTED_AFTER)):
        watch.check(SECOND, 0)
    assert warnings(inbox) == [MUTE_WARNING]


def test_sound_that_is_lost_again_and_again_is_told_now_and_then() -> None:
    now = 0.0
    inbox = Inbox(["stop"])
    watch = SoundWatch(inbox, lambda: now)
    watch.check(SECOND + 1, 1)
    watch.check(SECOND + 1, 3)
    now = LOSS_WARNING_INTERVAL
    watch.check(SECOND + 1, 4)
    lost = [f"{blocks * MICROPHONE_BLOCK_SECONDS:.2f} s of sound were lost" for blocks in (1, 3)]
    assert [line.split(":")[0] for line in warnings(inbox)] == lost
