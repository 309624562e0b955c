"""The microphone and recognizer of a node, by its parameters."""

from __future__ import annotations

import os
import tempfile
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

from voz.audio.capture.pulse import PULSE_DEVICE, SOURCE_VARIABLE
from voz.audio.playback.mixer import Mixer
from voz.config import Config
from voz.hearing.microphone_thread import Hearing, sound_card
from voz.inbox import Inbox
from voz.recognition.recognizer import Recognizer
from voz.recognition.speaker.profiles import load_profile
from voz.ros1.node import load_rospy
from voz.ros1.node_language import find_or_make_language
from voz.ros1.parameters import text


def make_hearing(
    settings: Config,
    inbox: Inbox,
    clock: Callable[[], float],
    loudspeaker: Mixer | None = None,
) -> Hearing:
    """Read the node's parameters and load the recognizer; its `with` block listens.

    The loudspeaker is one of this process, which the microphone hears too. Raises VozError.
    """
    with tempfile.TemporaryDirectory(prefix="voz-lm-") as folder:
        language, warnings = find_or_make_language(settings.lm, Path(folder), settings.language)
        for warning in warnings:
            load_rospy().logwarn(warning)
        profile = text("profile")
        known = load_profile(profile) if profile else None
        recognizer = Recognizer(language, settings.recognition, known)
    playback = loudspeaker if settings.speech.half_duplex else None
    return Hearing(
        recognizer,
        replace(sound_card(_device()), playback=playback),
        inbox,
        clock,
        never_missed=settings.recognition.never_missed,
    )


def _device() -> str | None:
    """Return the microphone: `~device` as in `voz run`, or `~mic_name`, a PulseAudio source."""
    device, source = text("device"), text("mic_name")
    if device or not source:
        return device
    os.environ[SOURCE_VARIABLE] = source
    return PULSE_DEVICE
