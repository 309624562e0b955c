"""The real decoder on real recordings, and how well a phrase fits a sound."""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np
import pytest
from recordings import Recording, spoken

from voz.audio import SAMPLE_RATE
from voz.errors import LanguageError
from voz.language.language_files import LanguageFiles
from voz.recognition.language import Language, load_language
from voz.recognition.pocketsphinx.decoder import (
    LEAST_PROBABILITY,
    Decoder,
    KeyphraseScorer,
    mean_start,
)

NOTHING = np.zeros(0, np.int16)


@pytest.fixture(scope="module", params=[True, False], ids=["wide", "narrow"])
def decoder(loaded: Language, request: pytest.FixtureRequest) -> Decoder:
    return Decoder(loaded, is_wide=request.param)


@pytest.fixture(scope="module")
def commands(recordings: list[Recording]) -> list[Recording]:
    return [r for r in recordings if r.kind == "command" and r.voice == "festival_slt"]


def test_a_command_is_understood(decoder: Decoder, commands: list[Recording]) -> None:
    assert [decoder.decode(r.samples(), mean_start(r.samples())) for r in commands] == [
        r.text for r in commands
    ]


def test_the_trigram_model_understands_commands_too(
    loaded: Language, commands: list[Recording]
) -> None:
    trigrams = Decoder(loaded, "lm")
    right = [trigrams.decode(r.samples(), mean_start(r.samples())) == r.text for r in commands]
    assert np.mean(right) >= 0.8


def test_no_sound_is_no_sentence(decoder: Decoder) -> None:
    assert decoder.decode(NOTHING, mean_start(NOTHING)) == ""


def test_the_same_audio_gives_the_same_answer_whatever_came_before(
    loaded: Language, recordings: list[Recording]
) -> None:
    clips = [r.samples() for r in recordings if r.kind in ("command", "near-miss")][::4]
    there, back = Decoder(loaded), Decoder(loaded)
    forward = [there.decode(c, mean_start(c)) for c in clips]
    assert forward == [back.decode(c, mean_start(c)) for c in clips[::-1]][::-1]


def test_the_mean_starts_higher_for_louder_speech(commands: list[Recording]) -> None:
    samples = commands[0].samples()
    first, quieter = (float(mean_start(s).split(",")[0]) for s in (samples, samples // 10))
    assert 10 < first - quieter < 15  # 20 dB at 0.66


def test_a_command_is_understood_at_any_level(decoder: Decoder, commands: list[Recording]) -> None:
    for gain in (0.05, 0.3, 1.0):
        clips = [((r.samples() * gain).astype(np.int16), r.text) for r in commands]
        assert [decoder.decode(c, mean_start(c)) for c, _ in clips] == [text for _, text in clips]


def test_missing_and_broken_language_files_are_one_clear_line(
    language: LanguageFiles, tmp_path: Path
) -> None:
    with pytest.raises(LanguageError, match="voz build-lm"):
        load_language(LanguageFiles(tmp_path))
    for path in language.generated:
        (tmp_path / path.name).write_bytes(path.read_bytes())
    broken = LanguageFiles(tmp_path)
    broken.lm.write_text("no model")
    with pytest.raises(LanguageError, match=r"comandos_voz\.lm: cannot be used"):
        load_language(broken)


PHONES = {
    "hey robot": ["HH", "EY", "R", "OW", "B", "AA", "T"],
    "computer": ["K", "AH", "M", "P", "Y", "UW", "T", "ER"],
    "athena": ["AH", "TH", "IY", "N", "AH"],
}


@pytest.fixture(scope="module")
def scorers() -> dict[str, KeyphraseScorer]:
    return {phrase: KeyphraseScorer(phones) for phrase, phones in PHONES.items()}


@pytest.mark.parametrize("text", PHONES)
def test_what_is_said_fits_better_than_what_is_not(
    scorers: dict[str, KeyphraseScorer], text: str
) -> None:
    scores = {phrase: scorer.score(spoken(text)) for phrase, scorer in scorers.items()}
    best = scores.pop(text)
    assert max(scores.values()) + 10 < best <= 0


def test_what_was_heard_before_changes_nothing(scorers: dict[str, KeyphraseScorer]) -> None:
    scorer = scorers["computer"]
    before = scorer.score(spoken("computer"))
    scorer.score(np.full(SAMPLE_RATE, 20_000, np.int16))
    assert scorer.score(spoken("computer")) == before


@pytest.mark.parametrize("seconds", [0.001, 0.01])
def test_what_is_too_short_fits_as_badly_as_can_be(
    scorers: dict[str, KeyphraseScorer], seconds: float
) -> None:
    samples = np.zeros(round(seconds * SAMPLE_RATE), np.int16)
    assert scorers["computer"].score(samples) == math.log(LEAST_PROBABILITY) / 8
