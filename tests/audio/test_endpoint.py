"""Speech is found where it is, whole, however the stream is cut into blocks."""

from __future__ import annotations

import itertools

import numpy as np
import pytest
from recordings import Recording

from voz.audio import SAMPLE_RATE, Samples
from voz.audio.endpoint import (
    LONGEST,
    Quiet,
    Segment,
    Segmenter,
    Sound,
    follow_closely,
    sounds,
)


def sounds_of(samples: Samples, block: int = SAMPLE_RATE) -> list[Sound]:
    segmenter = Segmenter()
    found: list[Sound] = []
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


def test_each_command_of_a_long_recording_is_a_segment(session: Recording) -> None:
    assert len(segments_of(session.samples())) == len(session.commands)


@pytest.mark.parametrize("block", [1, 333, 4801, 10**9])
def test_the_size_of_the_blocks_does_not_matter(block: int, session: Recording) -> None:
    samples = session.samples()[: 4 * SAMPLE_RATE]
    cut, whole = segments_of(samples, block), segments_of(samples)
    assert [(s.start, s.end) for s in cut] == [(s.start, s.end) for s in whole]
    for one, other in zip(cut, whole, strict=True):
        assert np.array_equal(one.samples, other.samples)


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


def test_speech_that_does_not_end_is_cut(session: Recording) -> None:
    samples = session.samples()
    loud = samples[np.abs(samples) > 2000]  # no pause is left in it
    endless = np.tile(loud, 30 * SAMPLE_RATE // len(loud) + 1)
    segments = segments_of(endless)
    assert len(segments) >= 3
    assert max(len(s.samples) for s in segments) <= LONGEST + 480
    assert all(b.start >= a.end for a, b in itertools.pairwise(segments))


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
    assert follow_closely(one, other) == close
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
