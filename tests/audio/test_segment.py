"""A segment that goes on: how it is followed, when it has ended, and into what it falls."""

from __future__ import annotations

import itertools

import numpy as np
from hypothesis import given
from hypothesis import strategies as st

from voz.audio.levels import FRAME
from voz.audio.segment import (
    CONTEXT_SAMPLES,
    END_FRAMES,
    HANGOVER_FRAMES,
    MIN_LOUD_FRAMES,
    SEGMENT_MARGIN,
    OpenSegment,
    pieces,
)

LOUD, LOW = 40.0, 10.0

frames = st.lists(st.tuples(st.booleans(), st.sampled_from([LOUD, LOW])), max_size=60)


def begun() -> OpenSegment:
    return OpenSegment(start=0, least=20.0, voices=0.0, before=30.0, levels=[], loud=2)


def test_a_level_that_falls_is_part_of_it_for_three_frames_more() -> None:
    now = begun()
    for _ in range(HANGOVER_FRAMES):
        now.follow(True, LOW)
    assert now.silent == 0
    now.follow(True, LOW)
    assert (now.silent, now.loud) == (1, 2)
    now.follow(True, LOUD)
    assert (now.silent, now.low, now.loud, now.loudest) == (0, 0, 3, LOUD)


@given(frames)
def test_it_has_ended_after_eight_silent_frames_and_not_before(
    seen: list[tuple[bool, float]],
) -> None:
    now = begun()
    followed = silent = 0
    for voice, level in [*seen, *[(False, LOW)] * END_FRAMES]:
        assert not now.ended
        now.follow(voice, level)
        followed += 1
        silent = 0 if voice and now.low <= HANGOVER_FRAMES else silent + 1
        if silent == END_FRAMES:
            break
    assert now.ended
    assert now.is_click == (now.loud < MIN_LOUD_FRAMES)
    heard = followed * FRAME
    assert now.paused_at(heard) == heard - END_FRAMES * FRAME + SEGMENT_MARGIN


@given(
    st.lists(
        st.tuples(st.integers(MIN_LOUD_FRAMES, 20), st.integers(END_FRAMES, 20)),
        min_size=1,
        max_size=5,
    )
)
def test_what_stood_out_of_what_goes_on_is_found_in_its_place(
    spells: list[tuple[int, int]],
) -> None:
    room = [LOW] * sum(loud for loud, _ in spells)  # most of the time nobody speaks
    levels = [*room, *(x for loud, low in spells for x in [LOUD] * loud + [LOW] * low)]
    now = begun()
    now.levels = levels
    begins = [n for n, x in enumerate(levels) if x == LOUD and levels[n - 1] == LOW]
    parts = list(now.divide(len(levels) * FRAME))
    assert [part.start for part in parts] == [n * FRAME - SEGMENT_MARGIN for n in begins]
    assert [part.loud for part in parts] == [loud for loud, _ in spells]
    assert all(part.ended and part.loudest == LOUD for part in parts)
    assert [part.before for part in parts] == [30.0] + [LOUD] * (len(parts) - 1)


def test_talk_that_goes_on_is_known_by_what_was_as_loud_before() -> None:
    sound = np.zeros(2 * FRAME, np.int16)
    for voices, before, within_talk in ((0.9, 35.0, True), (0.9, 32.0, False), (0.0, 35.0, False)):
        now = begun()
        now.voices, now.before, now.loudest = voices, before, LOUD
        segment = now.segment(FRAME, 2 * FRAME, sound, 0)
        assert segment.within_talk == within_talk
        assert (segment.start, segment.end, segment.decided) == (0, 0.03, 0.06)
        assert segment.above == 23.0


@given(st.integers(0, 9000), st.integers(0, 9000), st.integers(1, 9000), st.integers(0, 9000))
def test_what_is_around_it_is_what_is_remembered_and_was_heard(
    kept_from: int, before: int, length: int, heard: int
) -> None:
    """And nothing of what is remembered though it is not heard yet."""
    now = begun()
    now.start = kept_from + before
    end = now.start + length
    kept = np.arange(kept_from, end + heard + 100).astype(np.int16)
    segment = now.segment(end, end + heard, kept, kept_from)
    first, last = now.start - min(CONTEXT_SAMPLES, before), end + min(CONTEXT_SAMPLES, heard)
    assert np.array_equal(segment.samples, kept[before : before + length])
    assert np.array_equal(segment.with_surroundings, np.arange(first, last).astype(np.int16))
    assert len(segment.before) == now.start - first


def test_what_stands_out_is_found_and_short_gaps_divide_nothing() -> None:
    hum = [40.0] * 20
    usual, found = pieces([*hum, 60, 60, 42, 60, *hum, 55, 55, *hum], above=6, pause=4)
    assert usual == 40
    assert found == [(20, 24), (44, 46)]


def test_what_is_as_loud_all_the_time_has_no_pieces() -> None:
    assert pieces([50.0] * 100, above=3, pause=8) == (50.0, [])


@given(
    st.lists(st.floats(0, 90), min_size=1, max_size=80),
    st.floats(0.5, 10),
    st.integers(1, 10),
)
def test_pieces_are_apart_and_begin_and_end_with_what_stands_out(
    levels: list[float], above: float, pause: int
) -> None:
    usual, found = pieces(levels, above, pause)
    outside = set(range(len(levels)))
    for piece in found:
        assert levels[piece.start] > usual + above
        assert levels[piece.end - 1] > usual + above
        outside -= set(range(*piece))
    assert all(levels[frame] <= usual + above for frame in outside)
    assert all(b.start - a.end >= pause for a, b in itertools.pairwise(found))
