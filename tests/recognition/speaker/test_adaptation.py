"""What is learned of a microphone and a speaker, and what must not be."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

import numpy as np
import numpy.typing as npt
import pocketsphinx
import pytest
from recordings import Recording

from voz.api.recognizer import Recognizer
from voz.audio import SAMPLE_RATE, Samples
from voz.errors import LanguageError
from voz.language.acoustic_model import CEPSTRA, AcousticModel
from voz.language.language_files import LanguageFiles
from voz.language.spoken_language import ENGLISH_MODEL
from voz.recognition.engine import learned_by
from voz.recognition.language import Language
from voz.recognition.pocketsphinx.decoder import Decoder, mean_start
from voz.recognition.speaker.adaptation import (
    MAX_DOUBTS,
    MAX_FRAMES,
    MAX_SHIFT,
    Aligned,
    Aligner,
    Observation,
    StartVector,
    as_text,
    fit_transforms,
    is_transforms,
)
from voz.recognition.speaker.profiles import Profile
from voz.settings import Recognition

START = "45,3,-1"

ALONE = Recognition(use_network=False)
"""Pocketsphinx; the network needs no such help."""

BRIGHT = (3.0, -20.0, -10.0, *[5.0] * 10)
"""A microphone that is not the usual one."""


def learned(shift: Sequence[float] = BRIGHT, utterances: int = 20) -> StartVector:
    vector = StartVector()
    for _ in range(utterances):
        vector = vector.updated(Observation(tuple(shift), 60))
    return vector


def moved(vector: StartVector) -> npt.NDArray[np.float64]:
    """How far what was learned moves the start, shape (13,)."""
    return np.array([float(number) for number in vector.moved("0").split(",")])


@pytest.fixture(scope="module")
def aligner(loaded: Language) -> Aligner:
    return Aligner(loaded)


@pytest.fixture(scope="module")
def commands(recordings: list[Recording]) -> list[Recording]:
    return [r for r in recordings if r.kind == "command" and r.voice == "flite_awb"]


def observed(aligner: Aligner, samples: Samples, text: str) -> Observation:
    observation = aligner.observe(samples, text, START, StartVector())
    assert observation is not None
    return observation


def test_nothing_learnt_is_the_usual_start() -> None:
    assert StartVector().moved(START) == START


def test_what_is_heard_again_and_again_moves_the_start() -> None:
    assert np.allclose(moved(learned()), BRIGHT, atol=2)
    first, second, *_ = learned().moved("40,3,-1").split(",")
    assert (float(first), float(second)) == (pytest.approx(43, abs=1), pytest.approx(-17, abs=2))


def test_one_utterance_moves_the_start_by_half_of_the_way_at_most() -> None:
    once = StartVector().updated(Observation((10.0,) * 13, 10_000))
    assert np.all(np.abs(moved(once)) <= 5)


def test_one_wrong_utterance_moves_what_was_learnt_little() -> None:
    after = learned().updated(Observation((-10.0,) * 13, 10_000))
    assert np.abs(moved(after) - moved(learned())).max() < 2


def test_however_wrong_the_utterances_are_the_start_keeps_within_its_limits() -> None:
    for wild in (900.0, -900.0):
        assert np.all(np.abs(moved(learned([wild] * 13, 1000))) <= MAX_SHIFT)


def test_another_microphone_is_learnt_however_long_the_first_was_used() -> None:
    vector = learned(utterances=5000)
    assert vector.frames <= MAX_FRAMES
    for _ in range(60):
        vector = vector.updated(Observation((-5.0,) * 13, 60))
    assert np.allclose(moved(vector), -5, atol=3)


def test_the_odd_hit_in_an_hour_of_talk_teaches_little() -> None:
    vector = StartVector()
    for number in range(300):
        hit = number % 30 == 29
        vector = vector.updated(Observation(BRIGHT, 100)) if hit else vector.with_unused()
    assert np.all(np.abs(moved(vector)) < 0.25 * np.abs(BRIGHT))


def test_after_an_hour_of_talk_ten_commands_are_learnt_from_again() -> None:
    vector = StartVector()
    for _ in range(300):
        vector = vector.with_unused()
    for _ in range(10):
        vector = vector.updated(Observation(BRIGHT, 60))
    assert np.all(np.abs(moved(vector)) > 0.6 * np.abs(BRIGHT))


def test_it_is_forgotten_when_the_usual_start_understands_more() -> None:
    vector = learned()
    for _ in range(MAX_DOUBTS - 1):
        vector = vector.with_contradiction()
        assert vector.frames == learned().frames
    assert vector.with_contradiction() == StartVector()


def test_a_doubt_now_and_then_is_no_reason_to_forget() -> None:
    vector = learned()
    for _ in range(100):
        vector = vector.with_contradiction().updated(Observation(BRIGHT, 60))
    assert np.allclose(moved(vector), BRIGHT, atol=2)


def test_a_quieter_recording_is_seen_in_the_first_number_alone(
    aligner: Aligner, commands: list[Recording]
) -> None:
    loud = commands[0].samples()
    quiet = (loud / 4).astype(np.int16)
    text = commands[0].text
    change = np.subtract(observed(aligner, quiet, text).shift, observed(aligner, loud, text).shift)
    assert -14 < change[0] < -6  # 12 dB are ln(4) in each of 25 bands: 2 ln(4) sqrt(25 / 2) = 9.8
    assert np.all(np.abs(change[1:]) < 5)


def test_a_microphone_is_the_same_whatever_is_said_into_it(
    aligner: Aligner, commands: list[Recording]
) -> None:
    """The vowel of a word is not taken for the microphone."""
    clips = [(r, r.samples()) for r in commands]
    shifts = [observed(aligner, samples, r.text).shift for r, samples in clips]
    spread = np.std(shifts, axis=0)[1:4]
    assert np.all(spread < 8)


def test_a_filter_is_found(aligner: Aligner, commands: list[Recording]) -> None:
    """9 dB more for each octave tilt all commands by the same."""
    tilts = []
    for recording in commands[:5]:
        plain = recording.samples()
        spectrum = np.fft.rfft(plain.astype(float))
        ratio = np.fft.rfftfreq(len(plain), 1 / SAMPLE_RATE) / 1000
        filtered = np.fft.irfft(spectrum * np.maximum(ratio, 0.05) ** 1.5, len(plain))
        filtered *= np.abs(plain).max() / np.abs(filtered).max()
        before = observed(aligner, plain, recording.text)
        after = observed(aligner, filtered.astype(np.int16), recording.text)
        tilts.append(np.subtract(after.shift, before.shift)[1])
    assert np.all(np.array(tilts) < -15)
    assert np.std(tilts) < 6


def test_sound_that_cannot_hold_the_sentence_is_no_observation_and_does_no_harm(
    aligner: Aligner, commands: list[Recording]
) -> None:
    samples = commands[0].samples()
    expected = observed(aligner, samples, commands[0].text)
    for nothing in (np.zeros(0, np.int16), np.zeros(160, np.int16), samples[:800]):
        assert aligner.observe(nothing, "point cocacola", START, StartVector()) is None
    assert observed(aligner, samples, commands[0].text) == expected


def test_it_does_not_matter_what_was_aligned_before(
    aligner: Aligner, commands: list[Recording]
) -> None:
    clips = [(r.samples(), r.text) for r in commands[:5]]
    forwards = [observed(aligner, *clip) for clip in clips]
    backwards = [observed(aligner, *clip) for clip in reversed(clips)]
    assert forwards == backwards[::-1]


def test_a_missing_or_broken_acoustic_model_is_one_clear_line(tmp_path: Path) -> None:
    with pytest.raises(LanguageError, match="mdef"):
        AcousticModel(tmp_path)
    for name in ("mdef", "means", "variances", "sendump"):
        (tmp_path / name).write_bytes(b"nothing of the kind")
    with pytest.raises(LanguageError, match="install pocketsphinx again"):
        AcousticModel(tmp_path)


def telephone(plain: Samples) -> Samples:
    """Keep 300 to 3400 Hz, tilted by 6 dB for each octave."""
    frequency = np.fft.rfftfreq(len(plain), 1 / SAMPLE_RATE)
    band = ((frequency > 300) & (frequency < 3400)) + 0.01
    gain = band * np.maximum(frequency, 50) / 1000
    filtered = np.fft.irfft(np.fft.rfft(plain.astype(float)) * gain, len(plain))
    return (filtered * 0.1 * np.abs(plain).max() / np.abs(filtered).max()).astype(np.int16)


def right(recognizer: Recognizer, clips: list[tuple[Samples, str]]) -> int:
    heard = [[u.text for u in recognizer.utterances([samples], "")] for samples, _ in clips]
    return sum(texts == [text] for texts, (_, text) in zip(heard, clips, strict=True))


def test_a_bad_microphone_is_learnt_while_it_is_used(
    language: LanguageFiles, recordings: list[Recording]
) -> None:
    said = [r for r in recordings if r.kind == "command" and r.voice == "flite_slt"]
    clips = [(telephone(r.samples()), r.text) for r in said]
    learning = Recognizer(language, ALONE, learning=True)
    right(learning, clips)
    before = right(Recognizer(language, ALONE), clips)
    after = right(Recognizer(language, ALONE, Profile(learned_by(learning))), clips)
    assert before < after
    assert after >= 12
    assert right(Recognizer(language, Recognition()), clips) >= 12


def test_what_is_no_command_spoils_nothing(
    language: LanguageFiles, recordings: list[Recording]
) -> None:
    commands = [r for r in recordings if r.kind == "command"][::6]
    clips = [(r.samples(), r.text) for r in commands]
    learning = Recognizer(language, ALONE, learning=True)
    noise = np.random.default_rng(0).normal(0, 2000, (3, SAMPLE_RATE)).astype(np.int16)
    others = [r.samples() for r in recordings if r.kind == "near-miss"][::3]
    for samples in [*others, *noise]:
        list(learning.utterances([samples], ""))
    before = right(Recognizer(language, ALONE), clips)
    assert right(Recognizer(language, ALONE, Profile(learned_by(learning))), clips) >= before - 1


def test_recordings_are_each_heard_as_if_alone(recognizer: Recognizer, session: Recording) -> None:
    list(recognizer.utterances([session.samples()], "session"))
    assert learned_by(recognizer) == StartVector()


@pytest.fixture(scope="module")
def model() -> AcousticModel:
    return AcousticModel(Path(pocketsphinx.get_model_path(ENGLISH_MODEL)))


def spoken_by_the_model(model: AcousticModel, moved_by: float) -> Aligned:
    """Frames as the model expects them most, 20 of each of its phones, all moved by the same."""
    phones = np.repeat(np.arange(len(model.phones)), 20)
    senones = np.repeat(np.arange(len(model.phones)) * 3, 20)  # of phones without context
    gaussians = model.log_weights(senones)[0].argmax(axis=1)
    cepstra = model.means[phones, 0, gaussians] + moved_by
    return Aligned(cepstra, np.arange(len(phones)), phones, senones)


def test_without_speech_nothing_is_transformed(model: AcousticModel) -> None:
    for matrix, bias in fit_transforms([], model):
        assert np.allclose(matrix, np.eye(CEPSTRA), atol=1e-6)
        assert np.allclose(bias, 0, atol=1e-6)


def test_a_speaker_who_is_moved_is_found(model: AcousticModel) -> None:
    usual = model.means[:, 0].reshape(-1, CEPSTRA)
    found = []
    for moved_by in (0.0, 4.0):
        (matrix, bias), *_ = fit_transforms([(spoken_by_the_model(model, moved_by), "0")], model)
        found.append((usual @ matrix.T + bias).mean(axis=0))
    assert np.allclose(found[1] - found[0], 4, atol=2)


def test_pocketsphinx_reads_it_and_what_changes_nothing_changes_nothing(
    model: AcousticModel, loaded: Language, recordings: list[Recording], tmp_path: Path
) -> None:
    text = as_text(fit_transforms([], model))
    assert is_transforms(text)
    (tmp_path / "mllr.txt").write_text(text)
    plain, same = Decoder(loaded), Decoder(loaded, mllr=str(tmp_path / "mllr.txt"))
    (tmp_path / "upside_down.txt").write_text(text.replace("1.000000", "-1.000000"))
    wrong = Decoder(loaded, mllr=str(tmp_path / "upside_down.txt"))
    clips = [r for r in recordings if r.kind == "command"][::9]

    def decoded(decoder: Decoder) -> list[str]:
        return [decoder.decode(r.samples(), mean_start(r.samples())) for r in clips]

    assert decoded(same) == decoded(plain)
    assert decoded(wrong) != decoded(plain)


@pytest.mark.parametrize("text", ["", "1\n3\n13", "nonsense", "nan " * 587])
def test_what_is_no_transform_is_seen(text: str) -> None:
    assert not is_transforms(text)
