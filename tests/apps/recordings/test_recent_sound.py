"""The sound of an utterance is cut out of a stream exactly, whatever the blocks are."""

from __future__ import annotations

import numpy as np
from hypothesis import given
from hypothesis import strategies as st

from voz.apps.recordings.recent_sound import EXCERPT_MARGIN, LONGEST_KEPT, Excerpt, RecentSound
from voz.audio import SAMPLE_RATE
from voz.events import Utterance

STREAM = np.arange(3 * SAMPLE_RATE, dtype=np.int16)


def heard(start: float, end: float) -> Utterance:
    return Utterance(end, "stop", 0.9, True, start, end, "microphone")


def blocks_of(stream: np.ndarray, cuts: list[int]) -> list[np.ndarray]:
    return np.split(stream, sorted(cuts))


@given(
    st.lists(st.integers(1, len(STREAM) - 1), max_size=20),
    st.integers(0, len(STREAM)),
    st.integers(0, len(STREAM)),
    st.integers(0, 20),
)
def test_the_sound_comes_with_its_margins_as_soon_as_it_is_there(
    cuts: list[int], one: int, other: int, marked: int
) -> None:
    start, end = sorted((one, other))
    tape = RecentSound()
    pieces: list[Excerpt] = []
    fed = 0
    for number, block in enumerate(blocks_of(STREAM, cuts)):
        if number == marked:
            tape.mark(start / SAMPLE_RATE, end / SAMPLE_RATE, heard(0, 1))
        fed += len(block)
        found = list(tape.feed(block))
        assert not found or fed >= end + EXCERPT_MARGIN
        pieces += found
    if marked > len(cuts):
        tape.mark(start / SAMPLE_RATE, end / SAMPLE_RATE, heard(0, 1))
    pieces += tape.finish()
    (piece,) = pieces
    np.testing.assert_array_equal(
        piece.samples, STREAM[max(0, start - EXCERPT_MARGIN) : end + EXCERPT_MARGIN]
    )


def test_the_memory_of_a_long_stream_is_bounded_and_what_is_kept_is_right() -> None:
    tape = RecentSound()
    second = np.zeros(SAMPLE_RATE, np.int16)
    for number in range(100):
        assert list(tape.feed(second + np.int16(number))) == []
    tape.mark(80, 90, heard(80, 90))
    tape.mark(0, 10, heard(0, 10))  # long forgotten
    (piece,) = tape.finish()
    assert len(piece.samples) == 10 * SAMPLE_RATE + 2 * EXCERPT_MARGIN
    assert (piece.samples[0], piece.samples[-1]) == (79, 90)
    assert sum(map(len, tape._blocks)) <= LONGEST_KEPT + SAMPLE_RATE
