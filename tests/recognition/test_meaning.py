"""What may as well have been meant: another value of a slot."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
import soundfile
import soxr

from voz.audio import SAMPLE_RATE, Samples
from voz.language.build import build
from voz.language.files import LanguageFiles
from voz.language.templates.commands import Parse
from voz.recognition.evidence import SECOND_WEIGHT, Alignment, Evidence, Span
from voz.recognition.meaning import ENOUGH, SCALE, most_sure, rival, stands_in_the_way
from voz.recognition.recognizer import Recognizer
from voz.recognition.second_ear import Fit, Opinion
from voz.settings import Recognition
from voz.speech.festival import render

MEANT = {
    "bring a cup": Parse("bring a cup", "bring", {"thing": "cup"}),
    "bring the cup": Parse("bring the cup", "bring", {"thing": "cup"}),
    "bring a cap": Parse("bring a cap", "bring", {"thing": "cap"}),
    "bring a map": Parse("bring a map", "bring", {"thing": "map"}),
    "go back": Parse("go back", "go back"),
}


def heard(scores: dict[str, float], fits: dict[str, float] | None = None) -> Evidence:
    """The first sentence fits best; the second ear has no say unless it is told what it hears."""
    text, *others = scores
    command = Alignment(scores[text], (Span("bring", 0, 40, scores[text]),))
    fits = dict.fromkeys(scores, -5.0) | (fits or {})
    opinion = Opinion({command: Fit(fit, 9) for command, fit in fits.items()}, -1.0)
    return Evidence(text, command, {o: scores[o] for o in others}, Alignment(-50.0, ()), opinion)


def test_another_value_that_fits_as_well_takes_half_of_it() -> None:
    found = rival(heard({"bring a cup": -90.0, "bring a cap": -90.0}), MEANT.get)
    assert found == ("bring a cap", pytest.approx(0.5))
    both = rival(
        heard(dict.fromkeys(("bring a cup", "bring a cap", "bring a map"), -90.0)), MEANT.get
    )
    assert both
    assert both.left == pytest.approx(1 / 3)
    assert stands_in_the_way(both)
    assert most_sure(both) == both.left


def test_either_ear_may_be_sure_of_it() -> None:
    ahead = 3 * SCALE * np.sqrt(9)  # the phones of each
    first = rival(heard({"bring a cup": 0.0, "bring a cap": -ahead}), MEANT.get)
    fits = {"bring a cup": -1.0, "bring a cap": -1.0 - ahead / SECOND_WEIGHT}
    second = rival(heard({"bring a cup": -90.0, "bring a cap": -90.0}, fits), MEANT.get)
    assert first
    assert second
    assert first.left == pytest.approx(second.left) == pytest.approx(1 / (1 + np.exp(-3)))
    assert not stands_in_the_way(second)
    assert most_sure(second) == 1


def test_other_words_for_the_same_are_no_rival() -> None:
    same = heard({"bring a cup": -90.0, "bring the cup": -90.0})
    assert rival(same, MEANT.get) is None
    other = rival(
        heard({"bring a cup": -90.0, "bring the cup": -90.0, "go back": -900.0}), MEANT.get
    )
    assert other
    assert other.text == "go back"
    assert other.left > 0.99


def test_without_slots_or_a_second_ear_there_is_none() -> None:
    assert rival(heard({"go back": -90.0, "bring a cup": -90.0}), MEANT.get) is None
    alone = heard({"bring a cup": -90.0, "bring a cap": -90.0})._replace(opinion=None)
    assert rival(alone, MEANT.get) is None
    assert not stands_in_the_way(None)
    assert most_sure(None) == 1


@pytest.fixture(scope="module")
def turning(tmp_path_factory: pytest.TempPathFactory) -> Recognizer:
    """Knows angles, of which two sound nearly the same."""
    folder = tmp_path_factory.mktemp("turning")
    lines = ["turn left {angle} degrees", "stop", "angle = 5..180 by 5"]
    (folder / "list.txt").write_text("\n".join(lines))
    build(folder / "list.txt", folder)
    return Recognizer(LanguageFiles(folder), Recognition())


def said(text: str, folder: Path, noise: float) -> Samples:
    """A sentence in white noise, whose level beside the sentence's is in dB."""
    render(text, "cmu_us_slt_arctic_hts", folder / "said.wav")
    sound, rate = soundfile.read(folder / "said.wav")
    speech = soxr.resample(sound, rate, SAMPLE_RATE)
    level = np.sqrt((speech**2).mean()) * 10 ** (noise / 20)
    around = np.pad(speech, (2 * SAMPLE_RATE, SAMPLE_RATE))
    mixed = around + np.random.default_rng(0).normal(0, level, len(around))
    return (mixed / np.abs(mixed).max() * 20_000).astype(np.int16)


@pytest.mark.slow
@pytest.mark.parametrize("angle", ["fifteen", "fifty"])
def test_where_noise_covers_what_tells_two_apart_neither_is_obeyed(
    angle: str, turning: Recognizer, tmp_path: Path
) -> None:
    text = f"turn left {angle} degrees"
    clear = turning.decode(said(text, tmp_path, -40), SAMPLE_RATE)[-1]
    assert (clear.text, clear.accepted) == (text, True)
    for noise in (-6, -5, -4, -3):
        heard = turning.decode(said(text, tmp_path, noise), SAMPLE_RATE)[-1]
        assert not heard.accepted
        assert heard.reason == "unsure_between"
        assert heard.between
        assert heard.between[0] == heard.text != heard.between[1]
        assert heard.confidence < ENOUGH
