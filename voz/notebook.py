"""How an utterance looks in a notebook: what was heard, both opinions, and its sound.

Reads the recording that an utterance comes from, when it is shown.
"""

from __future__ import annotations

from base64 import b64encode
from collections import deque
from collections.abc import Iterable
from io import BytesIO
from pathlib import Path
from typing import TYPE_CHECKING

from voz.errors import AudioError
from voz.events import Utterance, explain

if TYPE_CHECKING:
    from voz.audio import Samples

MAX_PLAYED_SECONDS = 10.0
"""Of one utterance; a command takes two."""

MARGIN = 0.2
"""What is played before and after the speech, s."""

MAX_KEPT_SOUNDS = 64
"""Of utterances in arrays, which are no file to read again: 4 MB, or 20 MB of very long ones."""

_kept: deque[tuple[Utterance, Samples]] = deque(maxlen=MAX_KEPT_SOUNDS)


def keep_sounds(heard: Iterable[Utterance], samples: Samples) -> None:
    """Keep the sound of the last utterances of an array at 16 kHz, for `utterance_html`."""
    for utterance in deque(heard, maxlen=MAX_KEPT_SOUNDS):
        start, end = _played(utterance)
        _kept.append((utterance, samples[start:end].copy()))


def utterance_html(utterance: Utterance) -> str:
    """Describe an utterance in HTML, with a player if its sound is known."""
    from html import escape  # 0.5 MB that no run without a notebook needs

    text = f"“{escape(utterance.text)}”" if utterance.text else "no command"
    rows = "".join(
        f"<tr><th style='text-align:left'>{who}</th>"
        f"<td style='text-align:left'>{escape(said)}</td></tr>"
        for who, said in _opinions(utterance)
    )
    return (
        f"<div><strong>{text}</strong>, {escape(_verdict(utterance))}"
        f"<table>{rows}</table>{_player(_sound_of(utterance))}</div>"
    )


def _verdict(utterance: Utterance) -> str:
    if utterance.accepted:
        return "accepted"
    return f"not accepted: {explain(utterance.reason or 'not_a_command', utterance.between)}"


def _opinions(utterance: Utterance) -> Iterable[tuple[str, str]]:
    """Who has which opinion of an utterance, in words."""
    if not utterance.spoken:
        yield "Recognizer", "It was typed."
        return
    also = f" It might also have been “{utterance.next_best}”." if utterance.next_best else ""
    yield "Recognizer", f"It is {utterance.confidence:.0%} sure.{also}"
    if utterance.score is None:
        yield "Network", "It was not asked."
    elif utterance.score > 0:
        yield "Network", f"It hears these words, too: the evidence is {utterance.score:.1f}."
    else:
        yield "Network", f"It rather hears something else: the evidence is {utterance.score:.1f}."


def _played(utterance: Utterance) -> tuple[int, int]:
    """The samples of its source that are played, from and to, at 16 kHz."""
    from voz.audio import SAMPLE_RATE

    start = max(0.0, utterance.start - MARGIN)
    end = min(utterance.end + MARGIN, start + MAX_PLAYED_SECONDS)
    return round(start * SAMPLE_RATE), round(end * SAMPLE_RATE)


def _sound_of(utterance: Utterance) -> Samples | None:
    """The sound of an utterance; None if it is neither kept nor in a file that can be read."""
    for known, samples in tuple(_kept):
        if known is utterance:
            return samples
    start, end = _played(utterance)
    path = Path(utterance.source)
    if end <= start or not path.is_file():
        return None
    import numpy as np

    from voz.audio.sound_files import read_blocks

    found: list[Samples] = []
    missing = end - start
    try:
        for block in read_blocks(path, start):
            found.append(block[:missing])
            missing -= len(found[-1])
            if not missing:
                break
    except AudioError:
        return None
    return np.concatenate(found) if found else None


def _player(samples: Samples | None) -> str:
    if samples is None:
        return ""
    import soundfile

    from voz.audio import SAMPLE_RATE

    file = BytesIO()
    soundfile.write(file, samples, SAMPLE_RATE, format="WAV", subtype="PCM_16")
    data = b64encode(file.getvalue()).decode()
    return f'<audio controls src="data:audio/wav;base64,{data}"></audio>'
