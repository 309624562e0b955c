"""Long recordings in parts: whatever they hold, the results are those of one process."""

from __future__ import annotations

import tempfile
from pathlib import Path

import numpy as np
import numpy.typing as npt
import pytest
import soundfile
from hypothesis import given, settings
from hypothesis import strategies as st
from recordings import FIXTURES, Recording

from voz.api.recognizer import Recognizer
from voz.apps.batch import long_recordings
from voz.apps.batch.decoding import decode_recording
from voz.apps.batch.long_recordings import (
    DecodedPart,
    RecordingPart,
    decode_part,
    first_mismatch,
    outcome_of_parts,
    parts_of,
    plan_cuts,
    without_cut,
)
from voz.apps.batch.outcomes import ErrorRow, Outcome
from voz.audio import SAMPLE_RATE
from voz.recognition.interpreter import NO_DETAILS, Details

SHORT = 10.0
"""Parts that are cut so small that a recording of a minute has several, s."""


def in_parts(
    recognizer: Recognizer, path: Path, details: Details = NO_DETAILS
) -> tuple[Outcome, int, int]:
    """Decode in parts, as the scheduler does; gives how many there were, and were done anew."""
    plan = plan_cuts(path, SHORT)
    assert plan is not None

    def decoded(part: RecordingPart) -> DecodedPart:
        return decode_part(recognizer, path, part, str(path), details)

    done = list(map(decoded, parts_of(plan)))
    again = 0
    while (wrong := first_mismatch(done)) is not None:
        plan = without_cut(plan, wrong)
        done[wrong : wrong + 2] = [decoded(parts_of(plan)[wrong])]
        again += 1
    return outcome_of_parts(str(path), done), len(done), again


def recording(
    clips: list[Path], gaps: list[float], noise: float, seed: int
) -> npt.NDArray[np.int16]:
    """Clips with a pause after each, in a room."""
    rng = np.random.default_rng(seed)
    pieces = []
    for clip, gap in zip(clips, gaps, strict=True):
        pieces += [soundfile.read(clip, dtype="int16")[0], np.zeros(int(gap * SAMPLE_RATE))]
    sound = np.concatenate(pieces)
    return (sound + rng.normal(0, noise, len(sound))).clip(-32768, 32767).astype(np.int16)


FIXED = sorted((FIXTURES / "commands").glob("*.flac"))[::5]
GAPS = st.one_of(st.floats(0, 1), st.floats(4, 9))


@pytest.mark.slow
@settings(max_examples=12)
@given(
    said=st.lists(st.tuples(st.sampled_from(FIXED), GAPS), min_size=6, max_size=14),
    noise=st.sampled_from([0.0, 3.0, 100.0, 800.0]),
    rate=st.sampled_from([16000, 22050]),
    seed=st.integers(0, 99),
)
def test_parts_give_what_one_process_gives(
    recognizer: Recognizer, said: list[tuple[Path, float]], noise: float, rate: int, seed: int
) -> None:
    gaps = [gap for _, gap in said]
    gaps[1] = gaps[3] = 12.0
    sound = recording([clip for clip, _ in said], gaps, noise, seed)
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "long.wav"
        soundfile.write(path, sound, rate)
        if plan_cuts(path, SHORT) is None:  # the detector takes the noise for voices
            return
        whole = decode_recording(recognizer, path)
        parts, _, _ = in_parts(recognizer, path)
    assert (parts.rows, parts.seconds) == (whole.rows, whole.seconds)


def test_a_quiet_recording_is_cut_and_nothing_is_done_twice(
    recognizer: Recognizer, tmp_path: Path
) -> None:
    path, details = tmp_path / "long.flac", Details(words=True, best=2)
    soundfile.write(path, recording(FIXED[:6], [7.0] * 6, 3.0, 1), SAMPLE_RATE)
    parts, count, again = in_parts(recognizer, path, details=details)
    assert (count > 2, again) == (True, 0)
    assert parts.rows == decode_recording(recognizer, path, details=details).rows
    assert len(parts.rows) == 6


def test_where_parts_do_not_fit_both_are_done_as_one(
    recognizer: Recognizer, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Cut after so little silence that what was said before is not yet settled."""
    monkeypatch.setattr(long_recordings, "SILENT_FRAMES", 3)
    path = tmp_path / "long.wav"
    soundfile.write(path, recording(FIXED[:20], [0.5] * 20, 3.0, 1), SAMPLE_RATE)
    parts, _, again = in_parts(recognizer, path)
    assert again > 0
    assert parts.rows == decode_recording(recognizer, path).rows


def test_what_cannot_be_read_to_its_end_is_not_cut(session: Recording, tmp_path: Path) -> None:
    path = tmp_path / "cut.wav"
    path.write_bytes(session.path.read_bytes()[:-20000])
    assert plan_cuts(path, 1.0) is None


def test_a_recording_that_is_damaged_later_has_the_error_in_its_last_part(
    recognizer: Recognizer, tmp_path: Path
) -> None:
    path = tmp_path / "long.wav"
    soundfile.write(path, recording(FIXED[:6], [7.0] * 6, 3.0, 1), SAMPLE_RATE)
    plan = plan_cuts(path, SHORT)
    assert plan is not None
    path.write_bytes(path.read_bytes()[:-20000])
    done = [decode_part(recognizer, path, part, "it") for part in parts_of(plan)]
    assert isinstance(done[-1].rows[-1], ErrorRow)
    assert done[-1].rows[-1].error == decode_recording(recognizer, path).rows[-1].error
