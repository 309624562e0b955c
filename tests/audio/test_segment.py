"""A segment that goes on: how it is followed, when it has ended, and into what it falls."""

from __future__ import annotations

import itertools

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from voz.audio import SAMPLE_RATE
from voz.audio.levels import FRAME, BandLevels
from voz.audio.segment import (
    CONTEXT_SAMPLES,
    END_FRAMES,
    HANGOVER_FRAMES,
    MIN_LOUD_FRAMES,
    SEGMENT_MARGIN,
    OpenSegment,
    Segment,
    is_spoken_with,
    pieces,
)

LOUD, LOW = 40.0, 10.0
LOUD_FRAME, HISS, LOW_FRAME = (LOUD, LOW), (LOW, LOUD), (LOW, LOW)

frames = st.lists(
    st.tuples(st.booleans(), st.sampled_from([LOUD_FRAME, HISS, LOW_FRAME])), max_size=60
)


def begun() -> OpenSegment:
    return OpenSegment(
        start=0, least=20.0, least_high=20.0, voices=0.0, before=30.0, levels=[], loud=2
    )


def test_a_level_that_falls_is_part_of_it_for_three_frames_more() -> None:
    now = begun()
    for _ in range(HANGOVER_FRAMES):
        now.follow(True, LOW_FRAME)
    assert now.silent == 0
    now.follow(True, LOW_FRAME)
    assert (now.silent, now.loud) == (1, 2)
    now.follow(True, LOUD_FRAME)
    assert (now.silent, now.low, now.loud, now.loudest) == (0, 0, 3, LOUD)


@given(frames)
def test_it_has_ended_after_eight_quiet_frames_and_not_before(
    seen: list[tuple[bool, BandLevels]],
) -> None:
    now = begun()
    followed = quiet = silent = 0
    for voice, level in [*seen, *[(False, LOW_FRAME)] * END_FRAMES]:
        assert not now.ended
        now.follow(voice, level)
        followed += 1
        continues = voice and now.low <= HANGOVER_FRAMES
        silent = 0 if continues else silent + 1
        quiet = 0 if continues or (voice and level == HISS) else quiet + 1
        if quiet == END_FRAMES:
            break
    assert now.ended
    assert now.is_click == (now.loud < MIN_LOUD_FRAMES)
    heard = followed * FRAME
    assert now.ended_at(heard) == heard - END_FRAMES * FRAME + SEGMENT_MARGIN
    assert now.paused_at(heard) == heard - silent * FRAME + SEGMENT_MARGIN


def test_a_word_that_begins_and_ends_softly_is_whole_and_no_click() -> None:
    """As `eight`: its vowel takes 60 ms, its `t` comes later."""
    now = begun()
    for _ in range(HANGOVER_FRAMES + 2):
        now.follow(True, LOW_FRAME)
    assert (now.silent, now.quiet, now.is_click) == (2, 2, True)
    now.follow(False, HISS)  # of what has no voice in it
    assert (now.quiet, now.is_click) == (3, True)
    for _ in range(2):
        now.follow(True, HISS)
    assert (now.silent, now.quiet, now.is_click) == (5, 0, False)


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


def spoken(start: float, amplitude: float) -> Segment:
    """Half a second of a tone in a pause that is as long."""
    tone = np.sin(2 * np.pi * 500 / SAMPLE_RATE * np.arange(SAMPLE_RATE // 2))
    samples = np.concatenate([tone, np.zeros(SAMPLE_RATE // 2)]) * amplitude
    return Segment(start, start + 0.5, start + 0.6, samples.astype(np.int16))


@pytest.mark.parametrize(
    ("pause", "louder", "together"),
    [(0.5, 0, True), (0.7, 0, False), (0.5, -5, True), (0.5, -7, False), (0.5, 20, True)],
)
def test_what_is_close_to_a_command_and_not_much_quieter_is_spoken_with_it(
    pause: float, louder: float, together: bool
) -> None:
    """Before it and after it."""
    command, amplitude = spoken(10.0, 1000.0), 1000.0 * 10 ** (louder / 20)
    before, after = spoken(9.5 - pause, amplitude), spoken(10.5 + pause, amplitude)
    assert [is_spoken_with(command, other) for other in (before, after)] == [together] * 2


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
