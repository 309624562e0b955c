"""Speech is found where it is, whole, however the stream is cut into blocks."""

from __future__ import annotations

import itertools
from collections.abc import Callable

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from recordings import Recording, spoken

from voz.audio import SAMPLE_RATE, Samples
from voz.audio.levels import Floats
from voz.audio.segment import (
    CONTEXT_SAMPLES,
    CONTINUE_ABOVE,
    Quiet,
    Segment,
    SegmenterEvent,
    is_spoken_with,
)
from voz.audio.segmenter import MAX_SEGMENT_SECONDS, Segmenter, sounds


def sounds_of(samples: Samples, block: int = SAMPLE_RATE) -> list[SegmenterEvent]:
    segmenter = Segmenter()
    found: list[SegmenterEvent] = []
    for at in range(0, len(samples), block):
        found += segmenter.feed(samples[at : at + block])
    return found + list(segmenter.finish())


def segments_of(samples: Samples, block: int = SAMPLE_RATE) -> list[Segment]:
    return [sound for sound in sounds_of(samples, block) if isinstance(sound, Segment)]


def murmur(seconds: float) -> Samples:
    return np.random.default_rng(0).normal(0, 8, int(seconds * SAMPLE_RATE)).astype(np.int16)


def test_silence_has_no_speech() -> None:
    assert segments_of(murmur(3)) == []
    assert segments_of(np.zeros(0, np.int16)) == []


LONG_ORDER = "could i have a light roast triple shot iced mocha in a large cup right now"
REST = "with a little bit of brown sugar"


def in_two_breaths(noise: Floats) -> Samples:
    """A long order, a breath, and its rest, in noise a quarter as loud that is repeated."""
    begun = spoken(LONG_ORDER)
    around, breath = (np.zeros(int(s * SAMPLE_RATE), np.int16) for s in (3, 0.125))
    speech = np.concatenate([around, begun, breath, spoken(REST), around]).astype(float)
    stream = speech + 0.25 * np.std(begun) / np.std(noise) * np.resize(noise, len(speech))
    return np.rint(stream).clip(-32768, 32767).astype(np.int16)


def test_what_follows_a_breath_in_a_long_sentence_is_heard_in_noise() -> None:
    noise = np.random.default_rng(0).normal(0, 1, 12 * SAMPLE_RATE)
    _, rest = segments_of(in_two_breaths(noise))
    assert rest.end - rest.start > 0.8 * len(spoken(REST)) / SAMPLE_RATE


def test_a_rest_that_is_expected_is_heard_in_noise_that_sounds_like_a_voice() -> None:
    turns = 2 * np.pi * 110 * np.arange(SAMPLE_RATE) / SAMPLE_RATE
    hum = sum(np.sin(number * (turns + number)) / np.sqrt(number) for number in range(1, 30))
    segmenter, found = Segmenter(), []
    for block in np.array_split(in_two_breaths(hum), 100):
        for sound in segmenter.feed(block):
            if isinstance(sound, Segment):
                found.append(sound)
                segmenter.expect_rest()
    assert found[-1].start > 3 + len(spoken(LONG_ORDER)) / SAMPLE_RATE
    assert found[-1].end - found[-1].start > 0.8 * len(spoken(REST)) / SAMPLE_RATE


def test_each_command_of_a_long_recording_is_a_segment(session: Recording) -> None:
    assert len(segments_of(session.samples())) == len(session.commands)


def test_two_segments_are_joined_with_the_pause_between_them(session: Recording) -> None:
    samples = session.samples()
    kept = Segmenter(before=2 * SAMPLE_RATE)
    first, second = [s for s in kept.feed(samples) if isinstance(s, Segment)][:2]
    whole = first.joined(second)
    assert (whole.start, whole.end, whole.decided) == (first.start, second.end, second.decided)
    start, end = round(first.start * SAMPLE_RATE), round(second.end * SAMPLE_RATE)
    assert np.array_equal(whole.samples, samples[start:end])
    assert np.array_equal(whole.before, first.before)
    assert np.array_equal(whole.after, second.after)


def test_a_segment_is_the_stretch_of_the_stream_that_it_says(session: Recording) -> None:
    samples = session.samples()
    for segment in segments_of(samples):
        start, end = round(segment.start * SAMPLE_RATE), round(segment.end * SAMPLE_RATE)
        assert np.array_equal(segment.samples, samples[start:end])
        assert segment.start < segment.end <= segment.decided + 1e-9


def test_every_command_of_the_fixtures_is_one_segment(recordings: list[Recording]) -> None:
    commands = [r for r in recordings if r.kind == "command"]
    counts = [len(segments_of(r.samples())) for r in commands]
    assert counts == [1] * len(commands)


def test_a_clip_with_no_silence_around_it_keeps_its_first_and_last_sounds(
    recordings: list[Recording],
) -> None:
    for recording in recordings:
        if recording.kind == "command" and recording.voice == "flite_slt":
            samples = recording.samples()
            loud = np.flatnonzero(np.abs(samples) > 300)
            tight = samples[loud[0] : loud[-1] + 1]
            (segment,) = segments_of(tight)
            assert len(segment.samples) > 0.9 * len(tight)


def test_two_commands_close_together_are_two_segments(recordings: list[Recording]) -> None:
    clips = [r for r in recordings if r.kind == "command" and r.voice == "festival_slt"][:4]
    samples = np.concatenate([clip.samples() for clip in clips])  # 0.7 s in between
    assert len(segments_of(samples)) == len(clips)


def test_a_command_within_a_sound_that_goes_on_for_too_long_is_found(
    recordings: list[Recording],
) -> None:
    """A machine is switched on, works by fits and starts, and somebody speaks before it is over."""
    clip = next(r for r in recordings if r.kind == "command" and r.voice == "festival_slt")
    spoken = segments_of(clip.samples())[0].samples
    random = np.random.default_rng(0)
    swell = np.repeat(random.uniform(0.6, 1, 60), SAMPLE_RATE // 10)
    machine = (300 * swell * random.normal(0, 1, len(swell))).astype(np.int16)
    begin, at = 2 * SAMPLE_RATE, 3 * SAMPLE_RATE
    sound = np.concatenate([np.zeros(begin, np.int16), machine, np.zeros(SAMPLE_RATE, np.int16)])
    sound[at : at + len(spoken)] = mixed(sound[at : at + len(spoken)], spoken)
    segmenter = Segmenter(longest=2.5)
    found = [s for s in (*segmenter.feed(sound), *segmenter.finish()) if isinstance(s, Segment)]
    ends = at / SAMPLE_RATE, (at + len(spoken)) / SAMPLE_RATE
    assert any(
        abs(s.start - ends[0]) < 0.25 and abs(s.end - ends[1]) < 0.25 and s.above > 6 for s in found
    ), [(s.start, s.end) for s in found]


def test_speech_that_does_not_end_is_cut_and_then_is_the_background(session: Recording) -> None:
    samples = session.samples()
    loud = samples[np.abs(samples) > 2000]  # no pause is left in it
    endless = np.tile(loud, 30 * SAMPLE_RATE // len(loud) + 1)
    first, *others = segments_of(endless)
    assert len(first.samples) <= MAX_SEGMENT_SECONDS * SAMPLE_RATE + 480
    assert sum(len(s.samples) for s in others) < 5 * SAMPLE_RATE


def motors(seconds: float, loudness: float = 500) -> Samples:
    """A hum with its overtones that a gear modulates, and hiss."""
    time = np.arange(int(seconds * SAMPLE_RATE)) / SAMPLE_RATE
    hum = sum(np.sin(2 * np.pi * 110 * n * time) / n for n in range(1, 30))
    hiss = np.random.default_rng(1).normal(0, 1, len(time))
    return (loudness * (1 + 0.3 * np.sin(2 * np.pi * 7 * time)) * (hum + hiss)).astype(np.int16)


def mixed(one: Samples, other: Samples) -> Samples:
    return np.clip(one.astype(int) + other, -32768, 32767).astype(np.int16)


@pytest.mark.parametrize("noise", [motors, lambda s: murmur(s) * 40], ids=["motors", "hiss"])
def test_a_command_stands_out_of_a_noise_that_has_just_begun(
    noise: Callable[[float], Samples], recordings: list[Recording]
) -> None:
    clips = [r.samples() for r in recordings if r.voice == "flite_slt" and r.kind == "command"]
    for clip in clips:
        loud = np.flatnonzero(np.abs(clip) > 1500)
        spoken = clip[loud[0] : loud[-1]]
        begin = 2 * SAMPLE_RATE
        stream = np.concatenate([murmur(2), noise(5)])
        at = begin + int(0.75 * SAMPLE_RATE)
        stream[at : at + len(spoken)] = mixed(stream[at : at + len(spoken)], spoken)
        near = [
            s
            for s in segments_of(stream)
            if abs(s.start * SAMPLE_RATE - at) < 0.35 * SAMPLE_RATE
            and abs(s.end * SAMPLE_RATE - at - len(spoken)) < 0.35 * SAMPLE_RATE
        ]
        assert len(near) == 1


def test_commands_stand_out_of_one_who_talks_on(
    recordings: list[Recording], session: Recording
) -> None:
    talk = np.tile(session.samples()[SAMPLE_RATE // 2 :], 2) // 8
    clips = [r.samples() for r in recordings if r.voice == "flite_awb" and r.kind == "command"]
    stream, places = talk.copy(), []
    for number, clip in enumerate(clips[:8]):
        at = (5 + 4 * number) * SAMPLE_RATE
        stream[at : at + len(clip)] = mixed(stream[at : at + len(clip)], clip)
        loud = np.flatnonzero(np.abs(clip) > 1500)
        places.append((at + loud[0], at + loud[-1]))
    found = segments_of(stream)
    covered = [
        any(s.start * SAMPLE_RATE <= a and b <= s.end * SAMPLE_RATE for s in found)
        for a, b in places
    ]
    assert sum(covered) >= len(places) - 1


def around(segment: Segment, stream: Samples) -> Samples:
    """The stretch of the stream that the network hears, by the times of the segment."""
    start, end, decided = (round(time * SAMPLE_RATE) for time in segment[:3])
    return stream[max(0, start - CONTEXT_SAMPLES) : min(end + CONTEXT_SAMPLES, decided)]


def test_the_sound_around_a_segment_is_the_streams_also_where_another_is_near(
    session: Recording,
) -> None:
    """However little is remembered: the blocks are short, and one segment is just over."""
    samples = np.concatenate([s.samples for s in segments_of(session.samples())])  # no pauses
    for block in (480, 7000, len(samples)):
        segmenter = Segmenter(early=0.06, longest=2)
        found: list[Segment] = []
        for at in range(0, len(samples), block):
            for sound in segmenter.feed(samples[at : at + block]):
                if isinstance(sound, Segment):
                    found.append(sound)
                    segmenter.cut()
        assert len(found) > len(session.commands) / 2
        for segment in found:
            assert np.array_equal(segment.with_surroundings, around(segment, samples))
            assert len(segment.before) == min(CONTEXT_SAMPLES, round(segment.start * SAMPLE_RATE))


@given(
    seed=st.integers(0, 2**32 - 1),
    parts=st.lists(
        st.tuples(st.floats(0.02, 3), st.sampled_from([0, 3, 100, 1000, 8000])), max_size=12
    ),
    block=st.integers(1, 20000),
    early=st.sampled_from([None, 0.06, 0.3]),
)
@settings(deadline=None, max_examples=60)
def test_segments_are_in_order_and_in_the_stream_whatever_is_heard(
    seed: int, parts: list[tuple[float, int]], block: int, early: float | None
) -> None:
    random = np.random.default_rng(seed)
    pieces = [random.normal(0, level, int(s * SAMPLE_RATE)) for s, level in parts]
    joined = np.concatenate([np.zeros(0), *pieces])
    samples = np.clip(np.repeat(joined[::5], 5), -32768, 32767).astype(np.int16)
    found: list[list[SegmenterEvent]] = []
    for size in (block, len(samples) + 1):
        segmenter = Segmenter(early, longest=2)
        found.append([])
        for at in range(0, len(samples), size):
            found[-1] += segmenter.feed(samples[at : at + size])
        found[-1] += segmenter.finish()
    one, other = ([(type(s), *s[:3]) for s in each if isinstance(s, Segment)] for each in found)
    assert one == other
    for segment in (s for each in found for s in each if isinstance(s, Segment)):
        assert np.array_equal(segment.with_surroundings, around(segment, samples))
    whole = [s for s in found[0] if isinstance(s, Segment) and s.over]
    assert all(a.end <= b.start for a, b in itertools.pairwise(whole))
    for segment in whole:
        assert 0 <= segment.start < segment.end <= len(samples) / SAMPLE_RATE
        assert segment.end - segment.start <= 2 + 0.06
        assert len(segment.samples) == round((segment.end - segment.start) * SAMPLE_RATE)


def test_after_each_command_of_a_long_recording_it_is_quiet(session: Recording) -> None:
    found = list(sounds([session.samples()]))
    times = [sound.decided for sound in found]
    assert times == sorted(times)
    for one, other in itertools.pairwise(found):
        if isinstance(one, Segment) and isinstance(other, Segment):
            assert other.start - one.end < 1.1  # too soon to know that it stays quiet
    assert sum(isinstance(sound, Quiet) for sound in found) >= len(session.commands) - 2
    assert isinstance(found[-1], Quiet)


@pytest.mark.parametrize(("pause", "close"), [(0.3, True), (0.5, True), (1.2, False)])
def test_what_follows_closely_has_no_quiet_in_between(
    pause: float, close: bool, recordings: list[Recording]
) -> None:
    clips = [r.samples() for r in recordings if r.voice == "flite_slt" and r.kind == "command"]
    spoken = [clip[np.flatnonzero(np.abs(clip) > 300)[0] :] for clip in clips[:2]]
    first = spoken[0][: np.flatnonzero(np.abs(spoken[0]) > 300)[-1]]
    found = sounds_of(np.concatenate([first, murmur(pause), spoken[1]]))
    one, other = (sound for sound in found if isinstance(sound, Segment))
    assert is_spoken_with(one, other) == is_spoken_with(other, one) == close
    assert isinstance(found[1], Quiet) != close


@pytest.mark.parametrize("block", [333, 10**9])
def test_when_it_is_known_to_be_quiet_does_not_hang_on_the_blocks(
    block: int, session: Recording
) -> None:
    samples = session.samples()[: 6 * SAMPLE_RATE]
    quiet = [s.decided for s in sounds_of(samples, block) if isinstance(s, Quiet)]
    assert quiet == [s.decided for s in sounds_of(samples) if isinstance(s, Quiet)]
    assert quiet


def test_a_pause_is_told_before_the_segment_is_over(session: Recording) -> None:
    samples = session.samples()
    segmenter = Segmenter(early=0.06)
    found = [s for s in [*segmenter.feed(samples), *segmenter.finish()] if isinstance(s, Segment)]
    whole = [s for s in found if s.over]
    last = {s.start: s for s in found if not s.over}
    assert [(s.start, s.end) for s in whole] == [(s.start, s.end) for s in segments_of(samples)]
    for segment in whole:
        paused = last[segment.start]
        assert segment.decided - paused.decided > 0.1
        assert abs(segment.end - paused.end) <= 0.06
        assert np.array_equal(
            paused.samples, samples[round(paused.start * 16000) : round(paused.end * 16000)]
        )


def test_what_follows_a_cut_is_another_segment(session: Recording) -> None:
    segmenter = Segmenter(early=0.06)
    found = []
    samples = session.samples()
    for at in range(0, len(samples), 480):
        for sound in segmenter.feed(samples[at : at + 480]):
            if isinstance(sound, Segment):
                found.append(sound)
                segmenter.cut()
    assert not any(sound.over for sound in found)
    assert len(found) == len(session.commands)
    assert all(b.start >= a.end for a, b in itertools.pairwise(found))


def stood_out(segment: Segment) -> bool:
    return segment.above > 30 and not segment.within_talk


def test_a_segment_says_how_far_it_stands_out(session: Recording) -> None:
    quiet = segments_of(session.samples())
    assert all(stood_out(segment) for segment in quiet)
    noisy = segments_of(mixed(session.samples(), murmur(30)[: len(session.samples())] * 40))
    assert noisy
    assert all(CONTINUE_ABOVE < segment.above < 30 for segment in noisy)


def test_what_stands_out_of_talk_that_goes_on_and_is_as_loud_is_told(session: Recording) -> None:
    clip = session.samples()[int(0.6 * SAMPLE_RATE) : int(1.8 * SAMPLE_RATE)]
    talk = np.tile(clip, 12)
    louder = np.clip(clip.astype(int) * 2, -32768, 32767).astype(np.int16)
    found = segments_of(np.concatenate([talk, louder, murmur(1)]))
    assert any(segment.within_talk for segment in found)
    segmenter = Segmenter()
    list(segmenter.feed(talk))
    segmenter.mark_command()
    after = [*segmenter.feed(np.concatenate([louder, murmur(1)])), *segmenter.finish()]
    assert not any(isinstance(s, Segment) and s.within_talk and s.start > 14.3 for s in after)
