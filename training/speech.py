"""Clips to learn from: folders of speech with a `manifest.tsv`, and the phones that are known."""

from __future__ import annotations

import csv
import zlib
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from functools import lru_cache
from pathlib import Path

import numpy as np
import soundfile
from noises import Sound, changed_speed
from numpy.random import Generator

from voz.audio import SAMPLE_RATE
from voz.language.pronunciation import find_anywhere, look_up, read_cmudict
from voz.recognition.network.symbols import (
    OTHER_PHONE_SYMBOLS_FILE,
    read_phone_symbols,
    with_symbols,
)

LONGEST = 5.0
"""A longer clip is cut at random to so much, s, and loses its phones."""

HELD_BACK = 16
"""Of so many speakers one is never learned from; by it the network is judged."""

ENGLISH = "en"

CACHED = 60_000
"""Clips that are kept in memory."""


@dataclass(frozen=True)
class Clip:
    """A recording of speech.

    Attributes:
        path: of the file, 16 kHz.
        speaker: whose it is; a mixture of two voices is named by both, with a plus sign.
        seconds: how long it is.
        phones: CMUdict's, without stress, or in other languages than English those of
            `ipa_phones.tsv`, as they are said; None where they are not known.
        language: what is spoken.
        is_exact: whether a voice was given exactly these phones.
    """

    path: Path
    speaker: str
    seconds: float
    phones: tuple[str, ...] | None
    language: str = ENGLISH
    is_exact: bool = False

    @property
    def is_held_back(self) -> bool:
        """Whether its speaker, or one of two, is one by whom the network is judged."""
        return any(zlib.crc32(v.encode()) % HELD_BACK == 0 for v in self.speaker.split("+"))


@dataclass
class Pool:
    """Clips of speech, in groups that are drawn from alike often, and recorded noises."""

    groups: Sequence[Sequence[Clip]]
    noises: Sequence[Path]
    _noise_samples: dict[Path, Sound] = field(default_factory=dict)

    def speech(self, rng: Generator) -> Sound:
        """A clip of anybody."""
        return read(self._any(rng))

    def noise(self, length: int, rng: Generator) -> Sound | None:
        """A stretch of a recorded noise; None if there is none."""
        if not self.noises:
            return None
        whole = read(self.noises[rng.integers(len(self.noises))])
        start = int(rng.integers(max(1, len(whole) - length)))
        stretch = whole[start : start + length]
        return np.tile(stretch, length // len(stretch) + 1)[:length]

    def batch(self, size: int, rng: Generator) -> list[Clip]:
        """Clips of one language and of nearly one length, so that little silence is added."""
        weights = np.sqrt([sum(clip.seconds for clip in group) for group in self.groups])
        group = self.groups[rng.choice(len(self.groups), p=weights / weights.sum())]
        near = min(len(group), 6 * size)
        start = int(rng.integers(len(group) - near + 1))
        return [group[start + i] for i in rng.choice(near, min(size, near), replace=False)]

    def _any(self, rng: Generator) -> Path:
        group = self.groups[rng.integers(len(self.groups))]
        return group[rng.integers(len(group))].path


def load_pools(folders: Iterable[Path]) -> tuple[Pool, list[Clip]]:
    """Read the manifests of folders of speech.

    Args:
        folders: each with a `manifest.tsv` that has the columns path, speaker and seconds, and may
            have phones (with spaces), text, language, kind: `noise` is no speech, and exact, not
            empty where a voice was given exactly these phones.

    Returns:
        What is learned from, and the clips of the speakers who are held back.
    """
    cmudict = read_cmudict()
    groups, noises, held_back = [], [], []
    for folder in folders:
        with (folder / "manifest.tsv").open(encoding="utf-8", newline="") as file:
            rows = list(csv.DictReader(file, delimiter="\t", quoting=csv.QUOTE_NONE))
        noises += [folder / row["path"] for row in rows if row.get("kind") == "noise"]
        clips = [_clip(folder, row, cmudict) for row in rows if row.get("kind") != "noise"]
        held_back += [clip for clip in clips if clip.is_held_back]
        for language in dict.fromkeys(clip.language for clip in clips):
            own = [c for c in clips if c.language == language and not c.is_held_back]
            groups.append(sorted(own, key=lambda clip: clip.seconds))
    return Pool([group for group in groups if group], noises), held_back


def _clip(folder: Path, row: Mapping[str, str], cmudict: bytes) -> Clip:
    language = row.get("language") or ENGLISH
    phones = tuple(row.get("phones", "").split())
    if language == ENGLISH:
        phones = phones or _spoken(row.get("text", ""), cmudict)
    else:
        phones = with_symbols(phones)
    known = phones if phones and sounds_of(language).keys() >= {*phones} else None
    is_exact = bool(row.get("exact"))
    return Clip(
        folder / row["path"], row["speaker"], float(row["seconds"]), known, language, is_exact
    )


def sounds_of(language: str) -> Mapping[str, Sequence[str]]:
    """The symbols of the network for each phone that the labels of a language may have."""
    if language == ENGLISH:
        return read_phone_symbols()
    return read_phone_symbols(OTHER_PHONE_SYMBOLS_FILE)


def _spoken(text: str, cmudict: bytes) -> tuple[str, ...]:
    """The phones of a text of words that the dictionary has; empty if it lacks one of them."""
    phones: list[str] = []
    for word in text.lower().replace(",", " ").split():
        found = look_up(cmudict, word) or find_anywhere(cmudict, word)
        if not found:
            return ()
        phones += found[0].split()
    return tuple(phones)


def prepared(clip: Clip, rng: Generator) -> tuple[Sound, tuple[str, ...] | None]:
    """A clip at a speed of its own, with silence around it, and its phones if all are in it."""
    sound, phones = read(clip.path), clip.phones
    if rng.random() < 0.5:
        sound = changed_speed(sound, rng.uniform(0.88, 1.14))
    longest = int(LONGEST * SAMPLE_RATE)
    if len(sound) > longest:
        start = int(rng.integers(len(sound) - longest))
        sound, phones = sound[start : start + longest], None
    before, after = (int(max(0.0, rng.uniform(-0.2, 0.4)) * SAMPLE_RATE) for _ in range(2))
    return np.pad(sound, (before, after)), phones


def read(path: Path) -> Sound:
    """The samples of a file, from -1 to 1."""
    return _read(path).astype(np.float32) / 32768


@lru_cache(CACHED)
def _read(path: Path) -> np.ndarray:
    samples, rate = soundfile.read(path, dtype="int16", always_2d=True)
    if rate != SAMPLE_RATE:
        raise SystemExit(f"{path}: has {rate} Hz; convert it to {SAMPLE_RATE} Hz")
    return np.ascontiguousarray(samples[:, 0])
