"""Words that the network learned by heart, and writes as no dictionary has them."""

from __future__ import annotations

from functools import cache
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from synthesis import phrase, with_floor

from voz.audio import SAMPLE_RATE, Samples
from voz.language.build import build
from voz.language.files import LanguageFiles
from voz.language.lexicon import look_up, read_cmudict
from voz.recognition.recognizer import Recognizer
from voz.recognition.second_ear import SecondEar, load_network, read_readings
from voz.settings import Recognition

VOICES = ("festival_kal", "festival_slt", "flite_awb", "flite_rms", "espeak_us", "espeak_gb")

WORDS = {word: look_up(read_cmudict(), word) for word in sorted(read_readings())}
"""The words that have a reading, and their phones."""

SPELLINGS = {word: [way.split() for way in ways] for word, ways in WORDS.items()}


@cache
def said(word: str, voice: str) -> Samples:
    sound = with_floor(phrase(voice, word), np.random.default_rng(0))
    samples: Samples = (sound * 32767).astype(np.int16)
    return samples


@cache
def ears() -> tuple[SecondEar, SecondEar]:
    """One that knows the dictionary alone, and one that knows the readings too."""
    return SecondEar(SPELLINGS, {}), SecondEar(SPELLINGS)


@pytest.fixture(scope="module")
def answers(tmp_path_factory: pytest.TempPathFactory) -> Recognizer:
    folder = tmp_path_factory.mktemp("answers")
    (folder / "list.txt").write_text("yes\nno\none\ntwo\nfold arm\n")
    build(folder / "list.txt", folder / "lm")
    return Recognizer(LanguageFiles(folder / "lm"), Recognition())


@pytest.mark.parametrize("word", ["yes", "two"])
def test_short_answers_are_accepted_from_every_voice(word: str, answers: Recognizer) -> None:
    for voice in VOICES:
        heard = answers.decode(said(word, voice), SAMPLE_RATE)
        assert [(u.text, u.accepted) for u in heard] == [(word, True)], voice


def test_every_reading_is_of_a_known_word_in_symbols_of_the_network() -> None:
    symbols = set(load_network().symbols)
    assert {"yes", "one"} <= WORDS.keys()
    for word, reading in read_readings().items():
        assert WORDS[word], f"{word} is in no dictionary"
        assert reading
        assert set(reading) <= symbols, word


@given(
    st.sampled_from([*WORDS]),
    st.sampled_from([*WORDS, "stop"]),
    st.sampled_from(VOICES[2:]),
    st.integers(1, 4),
)
@settings(max_examples=30)
def test_a_reading_only_adds_to_what_a_word_may_sound_like(
    word: str, spoken: str, voice: str, parts: int
) -> None:
    samples = said(spoken, voice)
    samples = samples[: len(samples) * parts // 4]
    alone, both = (ear.opinion(samples, [word]) for ear in ears())
    assert both.best == pytest.approx(alone.best)
    assert both.fit(word) >= alone.fit(word) - 1e-6
    assert both.fits[word].phones in {len(way) for way in SPELLINGS[word]}


def test_what_the_network_writes_fits_where_the_dictionary_does_not() -> None:
    alone, both = ears()
    for voice in VOICES:
        samples = said("yes", voice)
        assert alone.opinion(samples, ["yes"]).fit("yes") < -2
        assert both.opinion(samples, ["yes"]).fit("yes") > -0.5


def test_the_readings_say_how_they_were_found() -> None:
    text = (Path(__file__).parents[2] / "voz/recognition/readings.tsv").read_text(encoding="utf-8")
    comments = [line for line in text.splitlines() if line.startswith("#")]
    rows = [line.split("\t") for line in text.splitlines() if not line.startswith("#")]
    columns = comments[-1].lstrip("# ").split("\t")
    assert columns == ["word", "reading", "recordings", "share", "dictionary", "with reading"]
    assert [row[0] for row in rows] == sorted({row[0] for row in rows})
    for _, _, recordings, share, before, after in rows:
        assert int(recordings) >= 4
        assert 0 < float(share) <= 1
        assert float(after) > float(before)
