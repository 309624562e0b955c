"""Many recordings, one after the other; one that cannot be read does not end the rest."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping
from pathlib import Path

import msgspec

from voz.audio.capture.files import read_blocks
from voz.errors import AudioError
from voz.events import Ear, Reason, RefusedBy, Utterance
from voz.files import shown_path
from voz.recognition.recognizer import Recognizer


class Decoded(msgspec.Struct, frozen=True, omit_defaults=True):
    """An utterance in a recording.

    Attributes:
        file: the recording.
        start: where the speech begins in it, s.
        end: where the speech ends in it, s.
        text: the sentence heard; empty if none fits.
        confidence: how sure it is, 0 to 1.
        accepted: whether it was recognised surely enough.
        reason: why not, if it would not.
        between: the two commands that it may be, if that is the reason.
        ears: as in `Utterance`, like those that follow.
    """

    file: str
    start: float
    end: float
    text: str
    confidence: float
    accepted: bool
    reason: Reason | None = None
    between: tuple[str, str] | None = None
    ears: tuple[Ear, Ear] | None = None
    refused_by: RefusedBy | None = None
    command: str | None = None
    slots: Mapping[str, str | int | float] = {}


class Unreadable(msgspec.Struct, frozen=True):
    """A recording that could not be read, or not to its end."""

    file: str
    error: str


def decode_recordings(
    recognizer: Recognizer, paths: Iterable[Path]
) -> Iterator[Decoded | Unreadable]:
    """Decode recordings, each as if it were alone.

    Args:
        recognizer: what understands them.
        paths: the recordings.

    Yields:
        The utterances of each recording in order; where reading fails, what was heard before it
        and then the error.
    """
    for path in paths:
        file = shown_path(path)
        try:
            for heard in recognizer.utterances(read_blocks(path), file):
                yield _in_file(heard, file)
        except AudioError as error:
            yield Unreadable(file, str(error))


def _in_file(heard: Utterance, file: str) -> Decoded:
    return Decoded(
        file,
        heard.start,
        heard.end,
        heard.text,
        heard.confidence,
        heard.accepted,
        heard.reason,
        heard.between,
        heard.ears,
        heard.refused_by,
        heard.command,
        heard.slots,
    )
