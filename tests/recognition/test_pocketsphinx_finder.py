"""What pocketsphinx alone makes of a stretch of speech, as in other languages."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from recordings import Recording

from voz.audio import SAMPLE_RATE
from voz.audio.segment import Segment
from voz.audio.segmenter import segments
from voz.language.build import build
from voz.language.language_files import LanguageFiles
from voz.recognition.confidence import POCKETSPHINX_FEATURES, VOICES_AROUND, load_models
from voz.recognition.finders import PocketsphinxFinder
from voz.recognition.language import Language, load_language
from voz.recognition.speaker.adaptation import StartVector
from voz.recognition.speaker.profiles import Profile
from voz.settings import Recognition


def finder(language: Language, settings: Recognition | None = None) -> PocketsphinxFinder:
    return PocketsphinxFinder(
        language, settings or Recognition(), Profile(), load_models().without_network
    )


@pytest.fixture(scope="module")
def ear_alone(loaded: Language) -> PocketsphinxFinder:
    return finder(loaded)


@pytest.fixture(scope="module")
def cut(recordings: list[Recording]) -> dict[str, Segment]:
    """The segment of each command, and of each near-miss."""
    own = [r for r in recordings if r.kind in ("command", "near-miss")]
    own = [r for r in own if r.voice == "festival_slt"]
    return {r.text: segment for r in own for segment in segments([r.samples()])}


def test_commands_are_found_and_there_is_a_next_best(
    ear_alone: PocketsphinxFinder, loaded: Language, cut: dict[str, Segment]
) -> None:
    for text in loaded.commands:
        heard = ear_alone.understand(cut[text], StartVector())
        assert (heard.text, heard.speech_probability) == (text, 1)
        assert {*heard.features} == {*POCKETSPHINX_FEATURES, VOICES_AROUND}
        assert heard.next_best in {*loaded.commands} - {text}
        assert heard.rival is None
        assert cut[text].start < heard.spoken_until <= cut[text].end


def test_the_reason_of_a_refusal_is_found_in_the_sound(
    ear_alone: PocketsphinxFinder, cut: dict[str, Segment]
) -> None:
    def why(segment: Segment) -> str:
        return ear_alone.understand(segment, StartVector()).why_refused()[0]

    assert why(cut["point"]) == "part_of_a_command"
    assert why(cut["the weather is nice today"]) == "not_a_command"
    stop = cut["stop"]
    assert why(stop._replace(samples=stop.samples // 300)) == "too_quiet"


def test_a_sound_too_short_for_any_command_is_said_to_be_so(
    cut: dict[str, Segment], tmp_path: Path
) -> None:
    (tmp_path / "list.txt").write_text("bring the " + " ".join(["strawberries"] * 8))
    build(tmp_path / "list.txt", tmp_path)
    patient = finder(load_language(LanguageFiles(tmp_path)))
    sound = cut["stop"].samples[: SAMPLE_RATE // 2]
    heard = patient.understand(Segment(0, 0.5, 0.5, sound), StartVector())
    assert (heard.text, heard.features, heard.probability) == ("", {}, 0)
    assert heard.why_refused() == ("too_short", None)


def test_words_of_the_trigram_model_that_are_no_command_are_compared_with_none(
    loaded: Language, cut: dict[str, Segment]
) -> None:
    trigrams = finder(loaded, Recognition(search="lm"))
    heard = trigrams.understand(cut["go back"], StartVector())
    assert (heard.text, bool(heard.features)) == ("go back", True)
    others = [
        trigrams.understand(s, StartVector()) for t, s in cut.items() if t not in loaded.commands
    ]
    words = [each for each in others if each.text and each.text not in loaded.commands]
    assert words
    assert all((each.features, each.probability) == ({}, 0) for each in words)
    assert {each.why_refused() for each in words} == {("not_a_command", None)}


def test_a_tap_is_no_speech(ear_alone: PocketsphinxFinder) -> None:
    time = np.arange(SAMPLE_RATE) / SAMPLE_RATE
    taps = 8000 * np.exp(-time % 0.2 * 60) * np.sin(2 * np.pi * 900 * time)
    heard = ear_alone.understand(Segment(0, 1, 1, taps.astype(np.int16)), StartVector())
    assert heard.probability == 0
    assert heard.why_refused() in (("no_speech", None), ("too_short", None))
