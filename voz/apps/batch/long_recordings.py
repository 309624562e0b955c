"""Long recordings in parts that many decode at once, with the results of one.

What a stream makes of a sound hangs on what was before it: on the voice detector, which never
forgets, on the level of the room in the last 8 s, and on what was said just before. The first is
found for all of the recording beforehand, which takes a thousandth of the time; the second from
the 9 s before a part; and a part begins where nothing is said. What each part hung on at its
beginning is compared with what the part before it left; where that differs, both are done anew as
one.
"""

from __future__ import annotations

import time
from collections.abc import Iterator, Sequence
from hashlib import sha256
from itertools import chain, pairwise
from pathlib import Path

import msgspec
import numpy as np
import numpy.typing as npt
from msgspec.structs import replace

from voz.apps.batch.outcomes import ErrorRow, Outcome, Row, make_outcome, utterance_row
from voz.apps.batch.stamps import Stamp
from voz.audio import SAMPLE_RATE, Samples
from voz.audio.capture.sound_files import header_seconds, read_blocks
from voz.audio.endpointing.frame_levels import FRAME
from voz.audio.endpointing.segmenter import WARM_UP_FRAMES, VoiceFlags, webrtc_detector
from voz.errors import AudioError
from voz.events import Utterance
from voz.recognition.recognizer import Recognizer

LONG_RECORDING_SECONDS = 600.0
"""What lasts longer is cut, s."""

PART_SECONDS = 300.0
"""How long a part is at least, s: the 9 s before it are 3 in 100 of it."""

SILENT_FRAMES = 150
"""Frames without a voice, 4.5 s: what was said before is settled, nothing else has begun."""


class CutPlan(msgspec.Struct, frozen=True):
    """How a recording is cut.

    Attributes:
        cuts: where parts begin, in frames: 0 first, and the end of the recording last.
        voices: in which frames there may be a voice, eight in each byte.
        stamp: what the recording was like before it was read; None if that is not known.
    """

    cuts: tuple[int, ...]
    voices: bytes
    stamp: Stamp | None = None

    def voices_in(self, start: int, end: int) -> bytes:
        """The same for some frames, a byte for each."""
        bits = np.unpackbits(np.frombuffer(self.voices, np.uint8))
        return bits[start:end].tobytes()


class RecordingPart(msgspec.Struct, frozen=True):
    """A part of a recording that is decoded alone.

    Attributes:
        start: where it begins, in frames.
        end: where it ends; None if that is the end of the recording.
        voices: a byte for each frame from `WARM_UP_FRAMES` before it: whether a voice may be in it.
    """

    start: int
    end: int | None
    voices: bytes


class DecodedPart(msgspec.Struct, frozen=True):
    """A part that was decoded.

    Attributes:
        rows: what was heard; an error is the last one.
        seconds: how much was heard, s.
        cpu: processor time that took, s.
        before: of what hung on the sound before it, at its beginning.
        after: the same for what follows; empty in the midst of speech.
    """

    rows: tuple[Row, ...]
    seconds: float
    cpu: float
    before: bytes
    after: bytes


def is_long(path: Path) -> bool:
    """Whether a recording is worth cutting, by what it promises."""
    try:
        return header_seconds(path) > LONG_RECORDING_SECONDS
    except AudioError:
        return False


def plan_cuts(path: Path, part: float = PART_SECONDS) -> CutPlan | None:
    """Find where a recording can be cut; None if it cannot, or cannot be read to its end.

    Args:
        path: the recording.
        part: how long a part is at least, s.
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


def decode_part(recognizer: Recognizer, path: Path, part: RecordingPart, file: str) -> DecodedPart:
    """Decode a part of a recording; its end belongs to the last one alone.

    Args:
        recognizer: what understands it.
        path: the recording.
        part: which one.
        file: the name of the recording for the rows.
    """
    begun = time.process_time()
    stream = recognizer.stream(file, spotting=False, voices=_known(part.voices))
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
    """Find a part that the next one does not follow from; None if all are right."""
    for number, (one, other) in enumerate(pairwise(done)):
        if not one.after or one.after != other.before:
            return number
    return None


def without_cut(plan: CutPlan, number: int) -> CutPlan:
    """Take two parts, of which one has this number and the other the next one, for one."""
    return replace(plan, cuts=tuple(cut for n, cut in enumerate(plan.cuts) if n != number + 1))


def outcome_of_parts(file: str, done: Sequence[DecodedPart], stamp: Stamp | None = None) -> Outcome:
    """The outcome of a recording from those of its parts."""
    rows = tuple(row for part in done for row in part.rows)
    # In whole samples: a sum of seconds may be rounded the other way than those of one process.
    samples = sum(round(part.seconds * SAMPLE_RATE) for part in done)
    whole = make_outcome(file, rows, samples / SAMPLE_RATE, sum(part.cpu for part in done))
    return replace(whole, stamp=stamp)


def _part(plan: CutPlan, start: int, end: int) -> RecordingPart:
    is_last = end == plan.cuts[-1]
    return RecordingPart(
        start, None if is_last else end, plan.voices_in(max(0, start - WARM_UP_FRAMES), end)
    )


def _cuts(voices: npt.NDArray[np.uint8], length: int) -> tuple[int, ...]:
    """Cut as soon as a part is long enough and it has been silent for a while."""
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
    """The first samples, and the rest."""
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
