"""What pays for a speaker is found, by sentences that it was not fitted on."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from recordings import Recording

from voz.api.recognizer import Recognizer
from voz.apps.recordings.calibration import (
    CALIBRATION_STEPS,
    Said,
    Score,
    calibrate,
    fit,
    score,
)
from voz.audio import SAMPLE_RATE, Samples
from voz.language.acoustic_model import Floats
from voz.language.language_files import LanguageFiles
from voz.recognition.language import Language
from voz.recognition.pocketsphinx.decoder import mean_start
from voz.recognition.speaker.adaptation import Aligner, is_transforms
from voz.recognition.speaker.profiles import Profile
from voz.settings import Recognition

ALONE = Recognition(use_network=False)
"""What is fitted helps pocketsphinx; with the network these voices need no help."""


@pytest.fixture(scope="module")
def aligner(loaded: Language) -> Aligner:
    return Aligner(loaded)


@pytest.fixture(scope="module")
def said(recordings: list[Recording]) -> list[Said]:
    """A speaker at a microphone that takes all below 300 and above 3400 Hz away, and tilts."""
    own = [r for r in recordings if r.kind == "command" and r.voice == "flite_slt"]
    return [Said(r.text, telephone(r.samples())) for r in own]


def telephone(plain: Samples) -> Samples:
    frequency = np.fft.rfftfreq(len(plain), 1 / SAMPLE_RATE)
    gain = (((frequency > 300) & (frequency < 3400)) + 0.01) * np.maximum(frequency, 50)
    filtered = np.fft.irfft(np.fft.rfft(plain.astype(float)) * gain, len(plain))
    return (filtered * 0.1 * np.abs(plain).max() / np.abs(filtered).max()).astype(np.int16)


def silence(seconds: float) -> Samples:
    return np.random.default_rng(0).normal(0, 8, int(seconds * SAMPLE_RATE)).astype(np.int16)


def mean_cepstra(aligner: Aligner, sentences: Sequence[Said]) -> Floats:
    """What the speech in sentences is on average, shape (13,)."""
    spoken = []
    for said in sentences:
        aligned = aligner.align(said.samples, said.text, mean_start(said.samples))
        assert aligned is not None
        spoken.append(aligned.cepstra[aligned.at])
    return np.asarray(np.concatenate(spoken).mean(axis=0))


@given(st.lists(st.tuples(*[st.integers(0, 20)] * 4), min_size=2, max_size=2))
def test_what_the_robot_would_do_counts_before_what_was_understood(
    counts: list[tuple[int, int, int, int]],
) -> None:
    one, other = (
        Score(20, right, accepted, wrong, sure) for right, accepted, wrong, sure in counts
    )
    first, second = ((each.accepted - each.wrong, each.right) for each in (one, other))
    assert first == second or (one.sort_key > other.sort_key) == (first > second)


def test_each_sentence_is_counted_once_for_what_was_heard(
    recognizer: Recognizer, recordings: list[Recording]
) -> None:
    clips = {r.text: r.samples() for r in recordings if r.voice == "festival_slt"}
    forward, back = clips["go forward"], clips["go back"]
    right = score([Said("go forward", forward)], recognizer)
    assert right[:4] == (1, 1, 1, 0)
    assert 0.9 < right.confidence <= 1
    assert score([Said("go forward", back)], recognizer) == Score(1, 0, 0, 1, 0)
    assert score([Said("go forward", silence(2))], recognizer) == Score(1, 0, 0, 0, 0)
    both = np.concatenate([forward, silence(1), back])
    assert score([Said("go forward", both)], recognizer) == Score(1, 0, 0, 1, 0)


def test_scores_of_several_sentences_are_added(
    recognizer: Recognizer, recordings: list[Recording]
) -> None:
    clips = {r.text: r.samples() for r in recordings if r.voice == "festival_slt"}
    some = [Said("go forward", clips["go forward"]), Said("stop", clips["go back"])]
    one, other = (score([sentence], recognizer) for sentence in some)
    total = score(some, recognizer)
    assert total[:4] == tuple(a + b for a, b in zip(one[:4], other[:4], strict=True))
    assert total.confidence == pytest.approx(one.confidence + other.confidence)


@pytest.mark.slow
def test_a_microphone_is_found_and_its_transform_is_written(
    aligner: Aligner, said: list[Said], recordings: list[Recording], tmp_path: Path
) -> None:
    profile = fit(said[:6], aligner, tmp_path / "mllr.txt")
    assert profile.mllr == str(tmp_path / "mllr.txt")
    assert is_transforms((tmp_path / "mllr.txt").read_text())
    plain = [Said(r.text, r.samples()) for r in recordings if r.voice == "flite_slt"][:6]
    usual = fit(plain, aligner, tmp_path / "plain.txt")
    found = np.subtract(profile.start.shift, usual.start.shift)
    real = mean_cepstra(aligner, said[:6]) - mean_cepstra(aligner, plain)
    # The first is the level, which is known before anything is learned.
    assert np.corrcoef(found[1:], real[1:])[0, 1] > 0.9


@pytest.mark.slow
def test_sentences_in_which_there_are_pauses_teach_nothing(
    aligner: Aligner, said: list[Said], tmp_path: Path
) -> None:
    broken = Said(said[0].text, np.concatenate([said[0].samples, silence(1), said[1].samples]))
    with_it = fit([*said[:4], broken], aligner, tmp_path / "with.txt")
    without = fit(said[:4], aligner, tmp_path / "without.txt")
    assert with_it.start == without.start
    assert (tmp_path / "with.txt").read_bytes() == (tmp_path / "without.txt").read_bytes()


def test_where_nothing_can_be_aligned_the_profile_is_empty_and_no_file_is_written(
    aligner: Aligner, tmp_path: Path
) -> None:
    assert fit([Said("go forward", silence(1))], aligner, tmp_path / "mllr.txt") == Profile()
    assert fit([], aligner, tmp_path / "mllr.txt") == Profile()
    assert list(tmp_path.iterdir()) == []


def scored(language: LanguageFiles, said: Sequence[Said], profile: Profile | None = None) -> Score:
    return score(said, Recognizer(language, ALONE, profile))


@pytest.mark.slow
def test_a_profile_is_worth_what_it_is_said_to_be(
    said: list[Said], language: LanguageFiles, tmp_path: Path
) -> None:
    steps: list[None] = []
    found = calibrate(said[:6], language, ALONE, tmp_path, lambda: steps.append(None))
    assert len(steps) == CALIBRATION_STEPS
    # Each sentence is heard as if alone, so that in parts they come to the same.
    before = scored(language, said[:6])
    assert found.before[:4] == before[:4]
    assert found.before.confidence == pytest.approx(before.confidence)
    assert found.after.sort_key > found.before.sort_key
    others = said[6:]
    assert scored(language, others, found.profile).sort_key >= scored(language, others).sort_key
    assert found.profile.model == ""  # pocketsphinx's own
    assert found.profile.mllr is None or Path(found.profile.mllr).parent == tmp_path
