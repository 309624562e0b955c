"""The real decoder on real recordings."""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np
import pytest
from recordings import Recording

from voz.errors import LanguageError
from voz.language.files import LanguageFiles
from voz.recognition.decoder import Decoder, PhoneLoop

NOTHING = np.zeros(0, np.int16)


@pytest.fixture(scope="module")
def decoder(language: LanguageFiles) -> Decoder:
    return Decoder(language)


@pytest.fixture(scope="module")
def phone_loop(language: LanguageFiles) -> PhoneLoop:
    return PhoneLoop(language)


@pytest.fixture(scope="module")
def commands(recordings: list[Recording]) -> list[Recording]:
    return [r for r in recordings if r.kind == "command" and r.voice == "festival_slt"]


def test_a_command_is_understood(decoder: Decoder, commands: list[Recording]) -> None:
    assert [decoder.decode(r.samples()) for r in commands] == [r.text for r in commands]


def test_the_trigram_model_understands_commands_too(
    language: LanguageFiles, commands: list[Recording]
) -> None:
    trigrams = Decoder(language, "lm")
    right = [trigrams.decode(r.samples()) == r.text for r in commands]
    assert np.mean(right) >= 0.8


def test_no_sound_is_no_sentence(decoder: Decoder, phone_loop: PhoneLoop) -> None:
    assert decoder.decode(NOTHING) == ""
    assert phone_loop.ratio(NOTHING, "stop") == -math.inf


def test_the_same_audio_gives_the_same_answer_whatever_came_before(
    language: LanguageFiles, recordings: list[Recording]
) -> None:
    clips = [r.samples() for r in recordings if r.kind in ("command", "near-miss")][::9]

    def answers(order: list[int]) -> dict[int, tuple[str, float]]:
        decoder, phone_loop = Decoder(language), PhoneLoop(language)
        return {i: (decoder.decode(clips[i]), phone_loop.ratio(clips[i], "stop")) for i in order}

    there = list(range(len(clips)))
    assert answers(there) == answers(there[::-1])


def test_a_sentence_that_was_said_explains_the_sound_better_than_one_that_was_not(
    phone_loop: PhoneLoop, commands: list[Recording]
) -> None:
    for recording in commands:
        samples = recording.samples()
        other = "slow down" if recording.text != "slow down" else "go back"
        assert phone_loop.ratio(samples, recording.text) > phone_loop.ratio(samples, other) + 1


def test_missing_and_broken_language_files_are_one_clear_line(
    language: LanguageFiles, tmp_path: Path
) -> None:
    with pytest.raises(LanguageError, match="voz build-lm"):
        Decoder(LanguageFiles(tmp_path))
    for path in (language.dictionary, language.lm, language.grammar):
        (tmp_path / path.name).write_bytes(path.read_bytes())
    broken = LanguageFiles(tmp_path)
    broken.grammar.write_text("#JSGF V1.0;\ngrammar g;\npublic <c> = unknown words;\n")
    with pytest.raises(LanguageError, match=r"comandos_voz\.gram: cannot be used"):
        Decoder(broken)
    broken.lm.write_text("no model")
    with pytest.raises(LanguageError, match=r"comandos_voz\.lm: cannot be used"):
        Decoder(broken, "lm")
