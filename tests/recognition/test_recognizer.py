"""What is understood of the fixtures, from file to utterance."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
import pytest
from recordings import Recording

from voz.audio import Samples
from voz.audio.files import read_blocks
from voz.config import Recognition
from voz.errors import AudioError
from voz.events import Utterance
from voz.language.files import LanguageFiles
from voz.recognition.recognizer import Recognizer


def utterances(recognizer: Recognizer, recording: Recording) -> list[Utterance]:
    return list(recognizer.utterances(read_blocks(recording.path), recording.path.name))


def share(values: list[bool]) -> float:
    return float(np.mean(values))


def test_festival_and_flite_are_understood(
    recognizer: Recognizer, recordings: list[Recording]
) -> None:
    clips = [r for r in recordings if r.kind == "command" and not r.voice.startswith("espeak")]
    heard = [[u.text for u in utterances(recognizer, r)] for r in clips]
    assert share([h == [r.text] for h, r in zip(heard, clips, strict=True)]) >= 0.97


def test_commands_are_accepted_and_most_near_misses_are_not(
    recognizer: Recognizer, recordings: list[Recording]
) -> None:
    def accepted(kind: str) -> float:
        clips = [r for r in recordings if r.kind == kind]
        return share([any(u.accepted for u in utterances(recognizer, r)) for r in clips])

    assert accepted("command") >= 0.9
    assert accepted("near-miss") <= 0.25


@pytest.mark.parametrize("kind", ["long", "format"])
def test_long_recordings_and_other_formats(
    kind: str, recognizer: Recognizer, recordings: list[Recording]
) -> None:
    for recording in recordings:
        if recording.kind == kind:
            heard = utterances(recognizer, recording)
            assert [u.text for u in heard] == recording.commands


def test_times_are_within_the_recording_and_in_order(
    recognizer: Recognizer, session: Recording
) -> None:
    heard = utterances(recognizer, session)
    times = [t for u in heard for t in (u.start, u.end)]
    assert times == sorted(times)
    assert all(u.start < u.end <= u.t < 23 for u in heard)
    assert {u.source for u in heard} == {"session.wav"}


def test_silence_gives_no_utterance(recognizer: Recognizer) -> None:
    silence = [np.zeros(16000, np.int16)] * 3
    assert list(recognizer.utterances(silence, "silence")) == []


def test_the_threshold_decides_what_is_accepted(
    language: LanguageFiles, recordings: list[Recording]
) -> None:
    clip = next(r for r in recordings if r.kind == "near-miss")
    (lenient,) = utterances(Recognizer(language, Recognition(threshold=0)), clip)
    (strict,) = utterances(Recognizer(language, Recognition(threshold=1)), clip)
    assert (lenient.text, lenient.confidence) == (strict.text, strict.confidence)
    assert lenient.accepted
    assert not strict.accepted


def test_words_of_the_trigram_model_that_are_no_command_are_not_accepted(
    language: LanguageFiles, recordings: list[Recording]
) -> None:
    trigrams = Recognizer(language, Recognition(search="lm", threshold=0))
    commands = {r.text for r in recordings if r.kind == "command"}
    heard = [u for r in recordings if r.kind == "near-miss" for u in utterances(trigrams, r)]
    assert [u for u in heard if u.text not in commands]
    assert all(u.accepted == (u.text in commands) for u in heard)


def test_what_was_heard_before_reading_failed_is_not_lost(
    recognizer: Recognizer, recordings: list[Recording]
) -> None:
    clip = next(r for r in recordings if r.kind == "command" and r.voice == "flite_slt")

    def failing() -> Iterator[Samples]:
        samples = np.concatenate(list(read_blocks(clip.path)))
        yield samples[: -len(samples) // 4]  # in the silence after the words
        raise AudioError("cut short")

    heard = []
    with pytest.raises(AudioError, match="cut short"):
        heard.extend(recognizer.utterances(failing(), "clip"))
    (utterance,) = utterances(recognizer, clip)
    first = next(recognizer.utterances(failing(), "clip"))
    assert first.text == utterance.text
