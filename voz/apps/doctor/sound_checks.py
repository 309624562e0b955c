"""Whether sound comes in and goes out, and whether the robot can speak. An edge."""

from __future__ import annotations

import tempfile
from pathlib import Path

import numpy as np

from voz.apps.doctor.finding import Finding, failed
from voz.audio import SAMPLE_RATE, Samples
from voz.audio.microphone import choose_microphone, open_microphone
from voz.audio.mixer import Mixer
from voz.audio.playback import PLAYBACK_RATE
from voz.audio.recording_level import Fault, measure_level
from voz.errors import AudioError, SpeechError
from voz.settings import Speech
from voz.speech import synthesis

LISTENING_TIME = 1
"""How long the microphone is listened to, s."""

PLAYED_SILENCE = 0.3
"""How long silence is played, s."""


def check_microphone(wanted: str | None = None) -> Finding:
    """Listen for a moment.

    Args:
        wanted: its number or a part of its name; None is the default one.
    """
    name = "microphone"
    try:
        device = choose_microphone(wanted, ", or type commands: `voz run --text -`")
        heard: Samples = np.empty(0, np.int16)
        with open_microphone(device.handle) as blocks:
            while len(heard) < LISTENING_TIME * SAMPLE_RATE:
                heard = np.concatenate([heard, next(blocks)])
    except AudioError as error:
        return failed(name, error)
    level = measure_level(heard)
    if level.still:
        return Finding(name, False, f"{device} is {Fault.SILENT.words}", Fault.SILENT.advice)
    status = f"{device} gives sound, at most {level.peak:.0f} dBFS; `voz devices --test` judges it"
    return Finding(name, True, status)


def check_loudspeaker(required: bool) -> Finding:
    """Play silence."""
    name = "loudspeaker"
    problems: list[str] = []
    mixer = Mixer(problems.append)
    try:
        mixer.wait(mixer.play(np.zeros(round(PLAYED_SILENCE * PLAYBACK_RATE), np.float32)))
    finally:
        mixer.close()
    if problems:
        return failed(name, AudioError(problems[0]), required)
    return Finding(name, True, "takes sound; `voz say hello` lets you hear it", required=required)


def check_festival(settings: Speech) -> Finding:
    """Let festival speak into a file."""
    name = "festival"
    if not settings.enabled:
        return Finding(name, True, "not needed: [speech] enabled = false", required=False)
    try:
        with tempfile.TemporaryDirectory(prefix="voz-") as folder:
            synthesis.render("ready", settings.voice, Path(folder) / "ready.wav")
    except SpeechError as error:
        return failed(name, error)
    return Finding(name, True, f"speaks with the voice {settings.voice}")
