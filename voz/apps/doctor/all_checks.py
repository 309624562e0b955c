"""All checks, in the order in which they are shown. An edge."""

from __future__ import annotations

import tempfile
import time
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import AbstractContextManager, contextmanager
from importlib.util import find_spec
from pathlib import Path

import numpy as np

from voz.apps.doctor.base_stop_check import BASE_STOPS, Base, check_stop
from voz.apps.doctor.finding import Finding, failed
from voz.apps.doctor.ros1_checks import check_ros1, open_ros1_base
from voz.audio import SAMPLE_RATE, Samples
from voz.audio.channels import OUT_OF_PHASE
from voz.audio.loudspeaker import Mixer
from voz.audio.microphone import choose_microphone, open_microphone
from voz.audio.playback import PLAYBACK_RATE
from voz.audio.recording_level import Fault, measure_level
from voz.config import Config
from voz.errors import AudioError, SpeechError, VozError
from voz.extras import how_to_install
from voz.language.language_files import (
    LanguageFiles,
    check_files,
    find_language,
    read_sentences,
    stale_warning,
)
from voz.recognition.engine import RecognitionEngine
from voz.recognition.network.phoneme_network import fingerprint_of
from voz.recognition.network.score import network_file, why_missing
from voz.settings import Recognition, Ros2, Speech
from voz.speech import synthesis

LANGUAGE_FILES = "language files"


def check_recognition(settings: Config) -> Iterator[Finding]:
    """Check the language files, then load the recognizer from them."""
    try:
        files = find_language(settings.lm, settings.language)
        check_files(files)
        yield _check_language(files)
        RecognitionEngine(files, settings.recognition)
    except VozError as error:
        yield failed(LANGUAGE_FILES, error)
        return
    yield Finding("recognizer", True, "loads")
    yield check_network(files, settings.recognition)


def check_network(files: LanguageFiles, settings: Recognition) -> Finding:
    """Check the phoneme network; without it more is accepted that is no command."""
    name = "phoneme network"
    if not settings.use_network:
        return Finding(name, True, "off: [recognition] use_network = false", required=False)
    if missing := why_missing(files, settings.network):
        remedy = "see [recognition] in docs/recognition.md; pocketsphinx decides alone until then"
        return Finding(name, False, f"none ({missing})", remedy, required=False)
    network = fingerprint_of(network_file(files, settings.network))
    return Finding(name, True, f"hears phonemes (network {network})", required=False)


def _check_language(files: LanguageFiles) -> Finding:
    if stale := stale_warning(files):
        return Finding(LANGUAGE_FILES, False, stale, "`voz build-lm` builds the files again")
    folder = files.folder.resolve()
    return Finding(LANGUAGE_FILES, True, f"{folder}: whole, {len(read_sentences(files))} commands")


LISTENING_TIME = 1
"""How long the microphone is listened to, s."""

PLAYED_SILENCE = 0.3
"""How long silence is played, s."""


def check_microphone(wanted: str | None = None) -> Finding:
    """Listen for a moment to a microphone: a number, or a part of a name; None is the default."""
    name = "microphone"
    try:
        device = choose_microphone(wanted, ", or type commands: `voz run --text -`")
        heard: Samples = np.empty(0, np.int16)
        with open_microphone(device.handle) as blocks:
            while len(heard) < LISTENING_TIME * SAMPLE_RATE:
                heard = np.concatenate([heard, next(blocks)])
            phase = f"; {OUT_OF_PHASE}" if blocks.out_of_phase else ""
    except AudioError as error:
        return failed(name, error)
    level = measure_level(heard)
    if level.still:
        return Finding(name, False, f"{device} is {Fault.SILENT.words}", Fault.SILENT.advice)
    status = f"{device} gives sound, at most {level.peak:.0f} dBFS; `voz devices --test` judges it"
    status += phase
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


def check_ros2(settings: Ros2) -> Iterator[Finding]:
    """Check ROS 2, for a robot that is driven by it."""
    try:
        import voz.ros2  # noqa: F401, it says what to do where cyclonedds is missing
        from voz.apps.doctor.ros2_checks import check_subscribers

        yield from check_subscribers(settings)
    except VozError as error:
        yield failed("ROS 2", error)


@contextmanager
def open_ros2_base(settings: Ros2, odometry: str) -> Iterator[Base]:
    """Open the base for a `with` block; raises VozError if the domain cannot be joined."""
    import voz.ros2  # noqa: F401, as above
    from voz.apps.doctor.ros2_checks import Ros2Base

    yield Ros2Base(settings, odometry, time.monotonic)


BASES: Mapping[str, Callable[[Config, str], AbstractContextManager[Base]]] = {
    "ros1": lambda settings, odometry: open_ros1_base(settings.ros1, odometry),
    "ros2": lambda settings, odometry: open_ros2_base(settings.ros2, odometry),
}
"""Opens the base of a robot, by the robot's name."""

EXTRA_MODULES: Mapping[str, tuple[str, ...]] = {
    "bags": ("rosbags",),
    "report": ("jiwer", "matplotlib"),
    "ros2": ("cyclonedds",),
}
"""What each extra of pyproject.toml brings."""


def check_all(settings: Config, robots: Sequence[str], device: str | None) -> Iterator[Finding]:
    """Check what a run with these robots needs; nothing moves.

    `device` is the microphone, by its number or a part of its name.
    """
    yield check_microphone(device)
    yield check_loudspeaker(settings.speech.enabled)
    yield check_festival(settings.speech)
    yield from check_recognition(settings)
    yield from check_ros1(settings.ros1, "ros1" in robots)
    if "ros2" in robots:
        yield from check_ros2(settings.ros2)
    yield from check_extras(frozenset({"ros2"}.intersection(robots)))


def check_base_stops(settings: Config, robot: str, odometry: str | None) -> Finding:
    """Drive the base of one of `BASES` for a moment, and check whether it stops by itself.

    `odometry` is the topic of the base's odometry; None as the settings say.
    """
    try:
        topic = odometry or getattr(settings, robot).odom
        with BASES[robot](settings, topic) as base:
            return check_stop(base)
    except VozError as error:
        return failed(BASE_STOPS, error)


def check_extras(required: frozenset[str] = frozenset()) -> Iterator[Finding]:
    """Check which extras are installed, the `required` ones among them."""
    for extra, modules in EXTRA_MODULES.items():
        missing = [module for module in modules if find_spec(module) is None]
        status = f"there is no {' and no '.join(missing)}" if missing else "is installed"
        remedy = how_to_install(extra) if missing else None
        yield Finding(f"extra {extra}", not missing, status, remedy, extra in required)
