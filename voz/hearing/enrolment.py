"""Asks a speaker for commands and keeps the recordings. An edge: it hears, shows and writes."""

from __future__ import annotations

import random
from collections import Counter
from collections.abc import Callable, Collection, Iterable, Iterator, Sequence
from pathlib import Path

import numpy as np
from rich.console import Console

from voz.audio import SAMPLE_RATE, Samples
from voz.audio.capture.files import read_blocks
from voz.audio.endpointing.segment import Segment
from voz.audio.endpointing.segmenter import Segmenter
from voz.audio.endpointing.voice import VoiceDetector
from voz.errors import ConfigError
from voz.files import told
from voz.recognition.confidence import NO_SPEECH
from voz.recognition.speaker.calibration import FEWEST, Said
from voz.recordings.keeping import keep
from voz.recordings.manifest import read_manifest
from voz.recordings.rows import MANIFEST
from voz.terminal.level_bar import level_bar

PROMPTS = 24
"""Commands to say: at 4 to 5 s each it takes two minutes."""

COLUMNS = ("path", "text", "speaker", "kind")

MARGIN = int(0.5 * SAMPLE_RATE)
"""Kept before the speech, so that the end-pointer finds it again."""

CLIPPED = 32_700
"""What is as loud as this is cut off at the top."""

INDENT = " " * 11  # what stands below "  1 of 24   "


def prompts(commands: Sequence[str], name: str) -> list[str]:
    """Choose what is to be said: every command, and some of them twice.

    Args:
        commands: the sentences of the language.
        name: of the profile; the same one gives the same order.
    """
    order = random.Random(name).sample(commands, len(commands))
    return (order + order)[:PROMPTS]


def missing(asked: Sequence[str], said: Iterable[Said]) -> list[str]:
    """Tell which prompts have no recording yet, in their order."""
    there = Counter(sentence.text for sentence in said)
    left = []
    for text in asked:
        there[text] -= 1
        if there[text] < 0:
            left.append(text)
    return left


def record(
    asked: Sequence[str], blocks: Iterator[Samples], folder: Path, name: str, console: Console
) -> None:
    """Let a speaker say commands, and keep each as soon as it is said.

    Args:
        asked: the commands, in the order in which they are shown.
        blocks: what the microphone hears, without an end.
        folder: where the recordings and their manifest are; it is made if need be.
        name: of the speaker, for the manifest.
        console: where the prompts and the level are shown.

    Raises:
        ConfigError: the recordings cannot be written.
        AudioError: the microphone fails.
    """
    voice = VoiceDetector()
    with level_bar(console, INDENT) as show:
        for number, text in enumerate(asked, start=1):
            console.print(f"{number:3} of {len(asked)}   say: {text}")
            while True:
                samples = _next_speech(_shown(blocks, show))
                complaint = _complaint(samples, voice)
                if complaint is None:
                    break
                console.print(f"{INDENT}{complaint}; say again: {text}")
            with told(folder):
                folder.mkdir(parents=True, exist_ok=True)
                keep(samples, folder, COLUMNS, (text, name, "command"))


def read_recordings(manifest: Path, commands: Collection[str]) -> list[Said]:
    """Read the recordings of one speaker; those of other sentences are left out.

    Args:
        manifest: a list of recordings, as `voz eval` reads it.
        commands: the sentences of the language.

    Raises:
        ConfigError: the list cannot be used, or holds too few commands or several speakers.
        AudioError: a recording cannot be read.
    """
    clips = [c for c in read_manifest(manifest) if c.kind == "command" and c.text in commands]
    speakers = sorted({clip.speaker for clip in clips})
    if len(speakers) > 1:
        raise ConfigError(
            f"{manifest}: has {len(speakers)} speakers ({', '.join(speakers)}); "
            "a profile is of one, so leave the others out"
        )
    if len({clip.text for clip in clips}) < FEWEST:
        raise ConfigError(
            f"{manifest}: has {len({clip.text for clip in clips})} different commands of this "
            f"language; record at least {FEWEST}"
        )
    return [Said(clip.text, np.concatenate(list(read_blocks(clip.path)))) for clip in clips]


def read_kept(folder: Path, commands: Collection[str]) -> list[Said]:
    """Read what `record` has kept so far; nothing if there is nothing."""
    manifest = folder / MANIFEST
    if not manifest.exists():
        return []
    clips = [clip for clip in read_manifest(manifest) if clip.text in commands]
    return [Said(clip.text, np.concatenate(list(read_blocks(clip.path)))) for clip in clips]


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
                begin = max(0, int(sound.start * SAMPLE_RATE) - MARGIN)
                return np.concatenate(heard)[begin:]
    raise AssertionError("a microphone has no end")


def _complaint(samples: Samples, voice: VoiceDetector) -> str | None:
    if np.abs(samples.astype(np.int32)).max() >= CLIPPED:
        return "that was too loud for the microphone"
    if voice.probability(samples[MARGIN:]) < NO_SPEECH:
        return "that was no speech"
    return None
