"""Calibration: asks a speaker for commands, saves them, finds how far to trust what is heard.

An edge: it hears, shows and writes.
"""

from __future__ import annotations

import math
import random
from collections import Counter
from collections.abc import Callable, Collection, Iterable, Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import NamedTuple

import numpy as np
from rich.console import Console

from voz.apps.recordings.manifest import MANIFEST_NAME, Clip, read_manifest
from voz.apps.recordings.recorder import save_recording
from voz.audio import SAMPLE_RATE, Samples
from voz.audio.segment import Segment
from voz.audio.segmenter import Segmenter
from voz.audio.sound_files import read_samples
from voz.audio.voice_detector import VoiceDetector
from voz.errors import ConfigError
from voz.events import Utterance
from voz.files import os_errors_as_config_error
from voz.language.language_files import LanguageFiles
from voz.recognition.confidence import NOISE_VOICE
from voz.recognition.engine import RecognitionEngine
from voz.recognition.language import load_language
from voz.recognition.profiles import Profile
from voz.settings import Recognition
from voz.terminal.level_bar import level_bar

MIN_SENTENCES = 5
"""Different sentences that a calibration needs."""

DOUBLINGS = (0, 1, 2)
"""How often the odds may be doubled; each lets twice as much else through."""

MIN_GAIN = 0.05
"""Share of the sentences that each doubling of the odds must gain."""


@dataclass(frozen=True)
class Said:
    """A recording (16 kHz) of one sentence by the speaker, and its file if it has one."""

    text: str
    samples: Samples
    file: Path | None = None


class Score(NamedTuple):
    """How well a speaker is understood; each number counts sentences."""

    sentences: int = 0
    right: int = 0  # understood, accepted or not
    accepted: int = 0  # understood and accepted
    wrong: int = 0  # something else was accepted


@dataclass(frozen=True)
class Calibration:
    """The best profile (empty if nothing helps), and the scores without and with it."""

    profile: Profile
    before: Score
    after: Score


def calibrate(
    said: Sequence[Said],
    language: LanguageFiles,
    settings: Recognition,
    advance: Callable[[], None] = lambda: None,
) -> Calibration:
    """Find the best profile of a speaker, by recordings of `MIN_SENTENCES` different sentences.

    `advance` is called after each of `DOUBLINGS`. Raises LanguageError.
    """
    model = load_language(language).spoken.model
    scores = {}
    for doublings in DOUBLINGS:
        tried = Profile(doublings * math.log(2), model)
        scores[doublings] = score(said, RecognitionEngine(language, settings, tried))
        advance()
    price = MIN_GAIN * len(said)
    best = max(scores, key=lambda d: scores[d].accepted - scores[d].wrong - d * price)
    profile = Profile(best * math.log(2), model) if best else Profile()
    return Calibration(profile, scores[0], scores[best])


def sentences_in(samples: Samples, recognizer: RecognitionEngine) -> list[Utterance]:
    """The sentences in a recording, accepted or not."""
    return [u for u in recognizer.utterances([samples], "") if u.text]


def score(said: Iterable[Said], recognizer: RecognitionEngine) -> Score:
    """Score a recognizer by known sentences."""
    total = Score()
    for sentence in said:
        text, heard = sentence.text, sentences_in(sentence.samples, recognizer)
        accepted = [u.text for u in heard if u.accepted]
        right = [u.text for u in heard] == [text]
        wrong = any(other != text for other in accepted)
        total = _sum(total, Score(1, right, right and bool(accepted), wrong))
    return total


def _sum(one: Score, other: Score) -> Score:
    return Score(*(a + b for a, b in zip(one, other, strict=True)))


PROMPT_COUNT = 24
"""Commands to say; at 4 to 5 s each they take two minutes."""

ENROLLMENT_COLUMNS = ("path", "text", "speaker", "kind")

MOST_TRIES = 2
"""A sentence that is misheard so often is saved as it is."""

SPEECH_MARGIN = int(0.5 * SAMPLE_RATE)
"""Samples before the speech, with which the end-pointer finds it again."""

CLIPPING_LEVEL = 32_700
"""Samples of this amplitude are clipped."""

PROMPT_INDENT = " " * 12  # as wide as "  1 of 24   "


def choose_prompts(commands: Sequence[str], name: str) -> list[str]:
    """Choose what is to be said: every command, some twice, in an order that the name decides."""
    order = random.Random(name).sample(commands, len(commands))
    return (order + order)[:PROMPT_COUNT]


def missing_prompts(asked: Sequence[str], said: Iterable[Said]) -> list[str]:
    """Return the prompts without a recording, in their order."""
    there = Counter(sentence.text for sentence in said)
    left = []
    for text in asked:
        there[text] -= 1
        if there[text] < 0:
            left.append(text)
    return left


def record_prompts(
    asked: Sequence[str],
    blocks: Iterator[Samples],
    recognizer: RecognitionEngine,
    *,
    folder: Path,
    name: str,
    console: Console,
) -> None:
    """Ask a speaker for commands, show what is heard, and save each as soon as it is said.

    What the recognizer mishears is asked for once more. The blocks are a microphone's and have no
    end. The folder gets the recordings and their manifest, with the speaker's name; it is made if
    need be.

    Raises:
        VozError: the recordings cannot be written, or the microphone fails.
    """
    voice = VoiceDetector()
    with level_bar(console, PROMPT_INDENT) as show:
        shown = _shown(blocks, show)
        for number, text in enumerate(asked, start=1):
            console.print(f"{number:3} of {len(asked)}   say: {text}")
            samples = _listen_for(text, shown, recognizer, voice, console)
            with os_errors_as_config_error(folder):
                folder.mkdir(parents=True, exist_ok=True)
                save_recording(samples, folder, ENROLLMENT_COLUMNS, (text, name, "command"))


def check_recording(text: str, samples: Samples, recognizer: RecognitionEngine) -> tuple[bool, str]:
    """Recognize a sentence; returns whether it was heard, and what was heard, in words."""
    heard = sentences_in(samples, recognizer)
    words = (u.text if u.accepted else f"{u.text} (unsure)" for u in heard)
    return [u.text for u in heard] == [text], " and ".join(words) or "no command"


def _listen_for(
    text: str,
    blocks: Iterator[Samples],
    recognizer: RecognitionEngine,
    voice: VoiceDetector,
    console: Console,
) -> Samples:
    """Listen until a sentence is heard right, or `MOST_TRIES` times wrong."""
    misheard = 0
    while True:
        samples = _next_speech(blocks)
        complaint = _complaint(samples, voice)
        if complaint is None:
            right, heard = check_recording(text, samples, recognizer)
            misheard += not right
            if right or misheard == MOST_TRIES:
                learning = "" if right else "; kept as it is"
                console.print(f"{PROMPT_INDENT}heard: {heard}{learning}")
                return samples
            complaint = f"heard: {heard}"
        console.print(f"{PROMPT_INDENT}{complaint}; say again: {text}")


def read_recordings(manifest: Path, commands: Collection[str]) -> list[Said]:
    """Read the recordings of one speaker whose text is one of the commands.

    Raises:
        ConfigError: the manifest cannot be used, or has too few commands or several speakers.
        AudioError: a recording cannot be read.
    """
    clips = [c for c in read_manifest(manifest) if c.kind == "command" and c.text in commands]
    speakers = sorted({clip.speaker for clip in clips})
    if len(speakers) > 1:
        raise ConfigError(
            f"{manifest}: has {len(speakers)} speakers ({', '.join(speakers)}); "
            "a profile is of one, so leave the others out"
        )
    if len({clip.text for clip in clips}) < MIN_SENTENCES:
        raise ConfigError(
            f"{manifest}: has {len({clip.text for clip in clips})} different commands of this "
            f"language; record at least {MIN_SENTENCES}"
        )
    return _read(clips)


def read_saved_recordings(folder: Path, commands: Collection[str]) -> list[Said]:
    """Read what `record_prompts` has saved so far."""
    manifest = folder / MANIFEST_NAME
    if not manifest.exists():
        return []
    return _read(clip for clip in read_manifest(manifest) if clip.text in commands)


def _read(clips: Iterable[Clip]) -> list[Said]:
    return [Said(c.text, read_samples(c.path), c.path) for c in clips]


def _shown(blocks: Iterator[Samples], show: Callable[[Samples], None]) -> Iterator[Samples]:
    for block in blocks:
        show(block)
        yield block


def _next_speech(blocks: Iterator[Samples]) -> Samples:
    """Listen until something was said; returns it with what is just before it."""
    segmenter = Segmenter()
    heard: list[Samples] = []
    for block in blocks:
        heard.append(block)
        for sound in segmenter.feed(block):
            if isinstance(sound, Segment):
                begin = max(0, int(sound.start * SAMPLE_RATE) - SPEECH_MARGIN)
                return np.concatenate(heard)[begin:]
    raise AssertionError("a microphone has no end")


def _complaint(samples: Samples, voice: VoiceDetector) -> str | None:
    if np.abs(samples.astype(np.int32)).max() >= CLIPPING_LEVEL:
        return "that was too loud for the microphone"
    if voice.probability(samples[SPEECH_MARGIN:]) < NOISE_VOICE:
        return "that was no speech"
    return None
