"""A command that stops is found in the midst of sound that goes on, and others are not."""

from __future__ import annotations

import numpy as np
from recordings import Recording

from voz.audio import SAMPLE_RATE, Samples
from voz.events import Partial
from voz.recognition.language import Language
from voz.recognition.phoneme_scorer import PhonemeScorer
from voz.recognition.recognizer import Recognizer
from voz.recognition.spotting import MIN_SPOTTING_SCORE, KeywordSpotter


def clips(recordings: list[Recording]) -> list[Recording]:
    close = ("festival_", "flite_", "kokoro")
    return [r for r in recordings if r.kind == "command" and r.voice.startswith(close)]


def test_it_is_found_with_sound_before_it_and_no_other_command_is_it(
    scorer: PhonemeScorer, loaded: Language, recordings: list[Recording]
) -> None:
    spotter = KeywordSpotter(scorer, ["stop"], loaded.commands.listed)
    hiss = np.random.default_rng(0).normal(0, 60, SAMPLE_RATE).astype(np.int16)
    found = {True: 0, False: 0}
    for clip in clips(recordings):
        samples = np.concatenate([hiss, clip.samples()])
        ends = range(len(hiss), len(samples), SAMPLE_RATE // 8)
        found[clip.text == "stop"] += any(spotter.spot(samples[:end]) for end in ends)
    stops = sum(clip.text == "stop" for clip in clips(recordings))
    others = sum("stop" not in clip.text for clip in clips(recordings))
    assert found[True] == stops > 3
    assert found[False] <= 0.1 * others + sum(c.text == "stop speech" for c in clips(recordings))


def test_the_best_of_several_commands_is_given(
    scorer: PhonemeScorer, loaded: Language, recordings: list[Recording]
) -> None:
    spotter = KeywordSpotter(scorer, ["stop", "turn left"], loaded.commands.listed)
    for text in ("stop", "turn left"):
        clip = next(r for r in recordings if (r.voice, r.text) == ("festival_slt", text))
        spotted = spotter.spot(clip.samples())
        assert spotted
        assert spotted.text == text
        assert spotted.score > MIN_SPOTTING_SCORE


def in_machines(samples: Samples) -> Samples:
    """Let a machine begin to sound a second before, that goes on long after."""
    rng = np.random.default_rng(0)
    seconds = np.arange(len(samples) + 5 * SAMPLE_RATE) / SAMPLE_RATE
    loud = 300 * (1 + 0.5 * np.sin(2 * np.pi * 3 * seconds)) * (seconds > 1)
    sound = loud * rng.normal(0, 1, len(seconds)) + rng.normal(0, 4, len(seconds))
    sound[2 * SAMPLE_RATE : 2 * SAMPLE_RATE + len(samples)] += samples
    return np.clip(np.rint(sound), -32768, 32767).astype(np.int16)


def test_among_machines_a_stop_is_told_before_it_pauses(
    recognizer: Recognizer, recordings: list[Recording]
) -> None:
    told = []
    for clip in clips(recordings):
        if clip.text != "stop":
            continue
        samples = clip.samples()
        said = np.flatnonzero(np.abs(samples) > np.abs(samples).max() / 20)[-1]
        until = 2 + said / SAMPLE_RATE
        events = recognizer.events([in_machines(samples)], "")
        first = next(e for e in events if isinstance(e, Partial) or e.accepted)
        is_in_time = until - 0.5 < first.t < until + 0.2
        told += [isinstance(first, Partial) and first.text == "stop" and is_in_time]
        assert 0 <= first.confidence <= 1
    assert len(told) > 3
    assert sum(told) >= len(told) - 1


def test_the_size_of_the_blocks_does_not_matter(
    recognizer: Recognizer, recordings: list[Recording]
) -> None:
    clip = next(r for r in recordings if (r.voice, r.text) == ("festival_slt", "stop"))
    samples = in_machines(clip.samples())
    whole = list(recognizer.events([samples], ""))
    for size in (333, 4801):
        cut = (samples[at : at + size] for at in range(0, len(samples), size))
        assert list(recognizer.events(cut, "")) == whole
