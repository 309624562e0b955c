"""Phrases spoken by the synthetic voices of Debian, as recordings with a manifest.

The engines give the same samples on every run and all noise is seeded, so the recordings stay
the same as long as the engines do.
"""

from __future__ import annotations

import subprocess
import tempfile
import zlib
from collections.abc import Callable
from dataclasses import dataclass
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt
import soundfile
import soxr

from voz.apps.recordings.manifest import MANIFEST_NAME, join_lines, parse_lines
from voz.audio import SAMPLE_RATE
from voz.errors import SpeechError

Sound = npt.NDArray[Any]
"""Samples between -1 and 1; more than one channel as columns."""

APT_PACKAGES = "festival festvox-kallpc16k festvox-kdlpc16k festvox-us-slt-hts flite espeak-ng"
ENGINE_SECONDS = 60.0

PEAK_DB = -5.5
"""Loud as a well-set recording, with room for the noise on top."""

FLOOR_DB = -71.0
"""The murmur of a quiet room. Digital zeros would be like no real recording."""

FRAME = SAMPLE_RATE // 100
QUIET_DB = -50.0
"""A frame this far below the loudest is the engine's own silence: the weakest `f` is louder."""

KEPT_FRAMES = 4
"""Kept around the speech, so that a soft beginning or a last breath is not cut."""

SECONDS_BEFORE, SECONDS_AFTER = 0.3, 0.4


@dataclass(frozen=True)
class Voice:
    """A program that reads text on stdin and writes a WAV file, named by its last argument."""

    command: tuple[str, ...]

    @classmethod
    def festival(cls, name: str) -> Voice:
        """A voice of festival. The name becomes Scheme: only ever one of the table below."""
        return cls(("text2wave", "-eval", f"(voice_{name})", "-o"))

    @classmethod
    def flite(cls, name: str) -> Voice:
        """A voice that is built into flite."""
        return cls(("flite", "-voice", name, "-o"))

    @classmethod
    def espeak(cls, name: str) -> Voice:
        """A language of espeak-ng."""
        return cls(("espeak-ng", "--stdin", "-v", name, "-w"))


VOICES = {
    "festival_kal": Voice.festival("kal_diphone"),
    "festival_ked": Voice.festival("ked_diphone"),
    "festival_slt": Voice.festival("cmu_us_slt_arctic_hts"),
    "flite_awb": Voice.flite("awb"),
    "flite_rms": Voice.flite("rms"),
    "flite_slt": Voice.flite("slt"),
    "espeak_us": Voice.espeak("en-us"),
    "espeak_gb": Voice.espeak("en-gb"),
}
"""One of each speaker: kal of flite is the same recordings as kal of festival."""

SPELLINGS = {"cocacola": "coca cola", "latte": "lah tay", "metre": "meter", "metres": "meters"}
"""How to write for the engines what they would pronounce wrongly."""


@dataclass(frozen=True)
class Fixture:
    """One recording to make."""

    file: str  # where, inside the folder of them all; the ending is the format
    text: str  # what is said in it
    voice: str  # who says it
    kind: str  # what it is for
    # Makes the samples, given the source of all the noise in them.
    render: Callable[[np.random.Generator], Sound]
    rate: int = SAMPLE_RATE  # of the file, in Hz

    def samples(self) -> Sound:
        """The samples, noise seeded by the name: one recording does not change the others."""
        return self.render(np.random.default_rng(zlib.crc32(self.file.encode())))


def clip(folder: str, kind: str, voice: str, text: str) -> Fixture:
    """One phrase as a recording of its own."""
    file = f"{folder}/{voice}__{text.replace(' ', '_')}.flac"
    return Fixture(file, text, voice, kind, lambda noise: with_floor(phrase(voice, text), noise))


def phrase(voice: str, text: str) -> Sound:
    """One phrase with silence around it."""
    return np.concatenate([silence(SECONDS_BEFORE), speak(voice, text), silence(SECONDS_AFTER)])


@cache
def speak(voice: str, text: str) -> Sound:
    """One phrase at 16 kHz and the usual level, without the engine's own silence."""
    words = [SPELLINGS.get(word, word) for word in text.split()]
    # The full stop makes a whole sentence of it, whose melody falls at the end.
    sound, rate = synthesize(VOICES[voice], f"{' '.join(words)}.\n")
    return normalized(trimmed(soxr.resample(sound, rate, SAMPLE_RATE)))


def synthesize(voice: Voice, text: str) -> tuple[Sound, int]:
    """Have an engine speak.

    Returns:
        The samples and their rate, as the engine made them.

    Raises:
        SpeechError: the engine or the voice is not installed, or failed.
    """
    with tempfile.TemporaryDirectory() as folder:
        file = Path(folder) / "speech.wav"
        try:
            subprocess.run(
                [*voice.command, str(file)],
                input=text,
                text=True,
                check=True,
                capture_output=True,
                timeout=ENGINE_SECONDS,
            )
            # text2wave reports success without a file when it does not know the voice.
            return soundfile.read(file)
        except (OSError, subprocess.SubprocessError, soundfile.LibsndfileError) as error:
            engine = " ".join(voice.command[:-1])
            raise SpeechError(
                f"{engine}: does not speak; install it with: apt-get install {APT_PACKAGES}"
            ) from error


def trimmed(sound: Sound) -> Sound:
    """Cut the silence before and after the speech, and smooth the cuts."""
    frames = sound[: len(sound) // FRAME * FRAME].reshape(-1, FRAME)
    levels = np.sqrt(np.mean(frames**2, axis=1))
    loud = np.flatnonzero(levels > levels.max() * gain(QUIET_DB))
    first = max(loud[0] - KEPT_FRAMES, 0)
    kept = sound[first * FRAME : (loud[-1] + 1 + KEPT_FRAMES) * FRAME].copy()
    ramp = np.linspace(0, 1, FRAME)
    kept[:FRAME] *= ramp
    kept[-FRAME:] *= ramp[::-1]
    return kept


def with_floor(sound: Sound, noise: np.random.Generator) -> Sound:
    """Lay the noise of a quiet room under a recording: mostly low, as walls let it through.

    White noise of the same level would make the files a fifth larger.
    """
    channels = sound.reshape(len(sound), -1).T
    room = [shaped(len(sound), noise, low) for _ in channels]
    return sound + gain(FLOOR_DB) * np.column_stack(room).reshape(sound.shape)


def shaped(length: int, noise: np.random.Generator, spectrum: Callable[[Sound], Sound]) -> Sound:
    """Noise of power 1 with a spectrum: a function from Hz to amplitude."""
    white = np.fft.rfft(noise.standard_normal(length))
    colored = np.fft.irfft(white * spectrum(np.fft.rfftfreq(length, 1 / SAMPLE_RATE)), n=length)
    return colored / power(colored)


def low(hertz: Sound) -> Sound:
    """The spectrum of what comes through walls and casings: 5 dB less with each octave."""
    return np.maximum(hertz, 60.0) ** -0.85


def silence(seconds: float) -> Sound:
    """Digital silence."""
    return np.zeros(round(seconds * SAMPLE_RATE))


def normalized(sound: Sound) -> Sound:
    """The same sound with its peak at the usual level."""
    return sound * gain(PEAK_DB) / np.abs(sound).max()


def power(sound: Sound) -> float:
    """Root mean square."""
    return float(np.sqrt(np.mean(sound**2)))


def gain(decibels: float) -> float:
    """The factor on the amplitude."""
    return float(10 ** (decibels / 20))


def write(folder: Path, made: list[tuple[Fixture, Sound]]) -> None:
    """Replace what an earlier run made by these recordings and their manifest."""
    manifest = folder / MANIFEST_NAME
    if manifest.exists():
        # By its list, not by folder: the user may have named one with other things in it.
        for row in parse_lines(manifest.read_text())[1:]:
            (folder / row.fields[0]).unlink(missing_ok=True)
    for fixture, samples in made:
        path = folder / fixture.file
        path.parent.mkdir(parents=True, exist_ok=True)
        soundfile.write(path, samples, fixture.rate, subtype="PCM_16")
    rows = sorted((each.file, each.text, each.voice, each.kind) for each, _ in made)
    manifest.write_text(join_lines([("file", "text", "voice", "kind"), *rows]))
