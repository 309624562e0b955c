"""Long recordings in parts that several workers decode, with the results of one.

A stream depends on the sound before: the voice detector on all of it, the level of the room on the
last 8 s, decoding on what was said just before. So voices are found for the whole recording first,
in a thousandth of the time; each part has 9 s of warm-up and begins in silence. The state at its
beginning is compared with that at the end of the part before; where they differ, both parts are
decoded again as one.
"""

from __future__ import annotations

import time
from collections.abc import Iterator, Sequence
from itertools import chain, pairwise
from pathlib import Path

import msgspec
import numpy as np
import numpy.typing as npt
from msgspec.structs import replace

from voz.apps.batch.outcomes import ErrorRow, Outcome, Row, make_outcome, utterance_row
from voz.apps.batch.stamps import Stamp
from voz.audio import SAMPLE_RATE, Samples
from voz.audio.levels import FRAME
from voz.audio.segmenter import WARM_UP_FRAMES, VoiceFlags, webrtc_detector
from voz.audio.sound_files import header_seconds, read_blocks
from voz.errors import AudioError
from voz.events import Utterance
from voz.files import sha256
from voz.recognition.engine import RecognitionEngine, open_stream
from voz.recognition.interpreter import NO_DETAILS, Details

LONG_RECORDING_SECONDS = 600.0
"""Longer recordings are cut, s."""

PART_SECONDS = 300.0
"""Shortest part, s: its warm-up of 9 s costs 3 %."""

SILENT_FRAMES = 150
"""Frames without a voice, 4.5 s, after which a cut is possible: all that was said is decoded."""


class CutPlan(msgspec.Struct, frozen=True):
    """How a recording is cut."""

    # where parts begin, in frames: 0 first, and the end of the recording last
    cuts: tuple[int, ...]
    voices: bytes  # in which frames there may be a voice, eight in each byte
    stamp: Stamp | None = None  # from before it was read

    def voices_in(self, start: int, end: int) -> bytes:
        """The voice flags of some frames, a byte for each."""
        bits = np.unpackbits(np.frombuffer(self.voices, np.uint8))
        return bits[start:end].tobytes()


class RecordingPart(msgspec.Struct, frozen=True):
    """A part of a recording that is decoded alone."""

    start: int  # in frames
    end: int | None  # in frames; None for the end of the recording
    # a byte for each frame, from `WARM_UP_FRAMES` before the start: whether a voice may be in it
    voices: bytes


class DecodedPart(msgspec.Struct, frozen=True):
    """A part that was decoded."""

    rows: tuple[Row, ...]  # an error is the last one
    seconds: float  # how much was heard, s
    cpu: float  # processor time, s
    before: bytes  # digest of the state of the stream at its beginning
    after: bytes  # the same at its end; empty in the midst of speech


def is_long(path: Path) -> bool:
    """Whether a recording is worth cutting, by the length in its header."""
    try:
        return header_seconds(path) > LONG_RECORDING_SECONDS
    except AudioError:
        return False


def plan_cuts(path: Path, part: float = PART_SECONDS) -> CutPlan | None:
    """Find where a recording can be cut into parts of at least so many seconds.

    Returns:
        None if it cannot be cut, or not be read to its end.
    """
    voices = webrtc_detector()
    try:
        found = bytes(voices(frame.tobytes()) for frame in _frames(read_blocks(path)))
    except AudioError:
        return None
    flags = np.frombuffer(found, np.uint8)
    cuts = _cuts(flags, int(part * SAMPLE_RATE / FRAME))
    return CutPlan(cuts, np.packbits(flags).tobytes()) if len(cuts) > 2 else None


def parts_of(plan: CutPlan) -> list[RecordingPart]:
    """The parts of a recording in their order."""
    return [_part(plan, one, other) for one, other in zip(plan.cuts, plan.cuts[1:], strict=False)]


def decode_part(
    recognizer: RecognitionEngine,
    path: Path,
    part: RecordingPart,
    file: str,
    details: Details = NO_DETAILS,
) -> DecodedPart:
    """Decode a part of a recording, which its rows name `file`; they have `details` besides."""
    begun = time.process_time()
    stream = open_stream(recognizer, file, False, _known(part.voices), details)
    rows: list[Row] = []
    heard = 0
    before = b""
    try:
        blocks = read_blocks(path, max(0, part.start - WARM_UP_FRAMES) * FRAME)
        if part.start:
            run_in, blocks = _first(blocks, min(part.start, WARM_UP_FRAMES) * FRAME)
            stream.warm_up(part.start * FRAME, run_in)
            before = _mark(stream.resting_state())
        for block in _until(blocks, part):
            heard += len(block)
            rows += [utterance_row(e, file) for e in stream.feed(block) if isinstance(e, Utterance)]
    except AudioError as error:
        failure: tuple[Row, ...] = (ErrorRow(file, str(error)),)
    else:
        failure = ()
    after = _mark(stream.resting_state())
    if part.end is None:
        rows += [utterance_row(e, file) for e in stream.finish() if isinstance(e, Utterance)]
    cpu = time.process_time() - begun
    return DecodedPart((*rows, *failure), heard / SAMPLE_RATE, cpu, before, after)


def first_mismatch(done: Sequence[DecodedPart]) -> int | None:
    """The index of the first part that the next one does not continue; None if all match."""
    for number, (one, other) in enumerate(pairwise(done)):
        if not one.after or one.after != other.before:
            return number
    return None


def without_cut(plan: CutPlan, number: int) -> CutPlan:
    """Join a part, by its index, and the next one."""
    return replace(plan, cuts=tuple(cut for n, cut in enumerate(plan.cuts) if n != number + 1))


def outcome_of_parts(file: str, done: Sequence[DecodedPart], stamp: Stamp | None = None) -> Outcome:
    """The outcome of a recording from its parts."""
    rows = tuple(row for part in done for row in part.rows)
    # In whole samples: a sum of seconds may be rounded differently.
    samples = sum(round(part.seconds * SAMPLE_RATE) for part in done)
    whole = make_outcome(file, rows, samples / SAMPLE_RATE, sum(part.cpu for part in done))
    return replace(whole, stamp=stamp)


def _part(plan: CutPlan, start: int, end: int) -> RecordingPart:
    is_last = end == plan.cuts[-1]
    return RecordingPart(
        start, None if is_last else end, plan.voices_in(max(0, start - WARM_UP_FRAMES), end)
    )


def _cuts(voices: npt.NDArray[np.uint8], length: int) -> tuple[int, ...]:
    """Cut where it has been silent for a while, as soon as a part is long enough."""
    heard = np.concatenate([[0], np.cumsum(voices)])
    silent = np.flatnonzero(heard[SILENT_FRAMES:] == heard[:-SILENT_FRAMES]) + SILENT_FRAMES
    cuts = [0]
    while True:
        at = np.searchsorted(silent, cuts[-1] + max(length, WARM_UP_FRAMES))
        if at >= len(silent) or len(voices) - silent[at] < length // 2:
            return (*cuts, len(voices))
        cuts.append(int(silent[at]))


def _frames(blocks: Iterator[Samples]) -> Iterator[Samples]:
    rest: Samples = np.empty(0, np.int16)
    for block in blocks:
        rest = np.concatenate([rest, block])
        whole = len(rest) // FRAME * FRAME
        yield from rest[:whole].reshape(-1, FRAME)
        rest = rest[whole:]


def _known(flags: bytes) -> VoiceFlags:
    following = iter(flags)
    return lambda _: bool(next(following))


def _first(blocks: Iterator[Samples], count: int) -> tuple[Samples, Iterator[Samples]]:
    """The first samples, and the remaining blocks."""
    taken: Samples = np.empty(0, np.int16)
    while len(taken) < count and (block := next(blocks, None)) is not None:
        taken = np.concatenate([taken, block])
    return taken[:count], chain([taken[count:]], blocks)


def _until(blocks: Iterator[Samples], part: RecordingPart) -> Iterator[Samples]:
    if part.end is None:
        yield from blocks
        return
    left = (part.end - part.start) * FRAME
    for block in blocks:
        yield block[:left]
        left -= len(block)
        if left <= 0:
            return


def _mark(state: bytes | None) -> bytes:
    return sha256(state).digest() if state else b""
