"""What the network makes of real commands, and of what is none."""

from __future__ import annotations

import math

import numpy as np
import pytest
from recordings import Recording

from voz.language.phone_distances import read_distances
from voz.recognition.language import Language
from voz.recognition.network_file import UnknownNetworkError
from voz.recognition.second_ear import Fit, Opinion, SecondEar


def best_of(opinion: Opinion) -> str:
    return max(opinion.fits, key=lambda command: opinion.fits[command].score)


def test_it_knows_which_command_was_said(
    ear: SecondEar, loaded: Language, recordings: list[Recording]
) -> None:
    said = [r for r in recordings if r.kind == "command"]
    opinions = [ear.opinion(r.samples(), loaded.commands.listed) for r in said]
    right = [best_of(o) == r.text for o, r in zip(opinions, said, strict=True)]
    assert np.mean(right) > 0.97
    assert all(-9 < o.fit(best_of(o)) < 0.5 for o in opinions)
    assert all(o.margin(best_of(o)) > 0 for o in opinions)


def test_what_is_no_command_fits_worse(
    ear: SecondEar, loaded: Language, recordings: list[Recording]
) -> None:
    fits: dict[str, list[float]] = {"command": [], "near-miss": []}
    for recording in recordings:
        if recording.kind in fits:
            opinion = ear.opinion(recording.samples(), loaded.commands.listed)
            fits[recording.kind].append(opinion.fit(best_of(opinion)))
    assert np.percentile(fits["near-miss"], 80) < np.percentile(fits["command"], 20)


def test_other_commands_change_nothing_for_a_command(
    ear: SecondEar, loaded: Language, recordings: list[Recording]
) -> None:
    sound = next(r for r in recordings if r.text == "go back").samples()
    among, alone = ear.opinion(sound, loaded.commands.listed), ear.opinion(sound, ["go back"])
    assert among.fits["go back"].score == pytest.approx(alone.fits["go back"].score)
    assert alone.margin("go back") == math.inf


def test_of_the_ways_to_say_it_the_best_counts() -> None:
    opinion = Opinion({"stop": Fit(-4.0, 4), "go back": Fit(-30.0, 5)}, best=-2.0)
    assert opinion.fit("stop") == -0.5
    assert opinion.margin("stop") == 26 / 4
    assert opinion.margin("go back") == -26 / 5


def test_every_phone_of_the_acoustic_model_has_its_sounds() -> None:
    SecondEar({"all": [sorted(read_distances().frames)]})


def test_it_knows_no_phones_of_other_languages() -> None:
    with pytest.raises(UnknownNetworkError, match="no phone rr"):
        SecondEar({"rojo": [["R", "rr", "R"]]})


def test_a_sentence_of_many_ways_to_say_it_is_no_burden() -> None:
    ways = [["AH", "S"], ["EY", "S"], ["IY", "S"]]
    ear = SecondEar(dict.fromkeys("abcdefghijkl", ways))
    opinion = ear.opinion(np.zeros(16000, np.int16), [" ".join("abcdefghijkl")])
    assert opinion.fits["a b c d e f g h i j k l"].phones == 24
