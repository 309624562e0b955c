"""An order that is said in two breaths is one order, and `stop` after it is none of it."""

from __future__ import annotations

import functools
from pathlib import Path

import numpy as np
import pytest
from recordings import spoken

from voz.api.recognizer import Recognizer
from voz.audio import SAMPLE_RATE, Samples, segmenter
from voz.events import Utterance
from voz.language.build import build
from voz.language.language_files import LanguageFiles
from voz.recognition.engine import open_stream
from voz.settings import Recognition

LIST = """
order: make me [an iced] {drink} [with {extra}]
set servo {number: 1..3} to {angle: 10..50 by 5}
stop
drink = coffee | mocha
extra = brown sugar | almond milk
"""

BREATH = 0.4


def recognizer_of(listed: str, folder: Path) -> Recognizer:
    (folder / "list.txt").write_text(listed)
    build(folder / "list.txt", folder)
    return Recognizer(LanguageFiles(folder), Recognition())


@pytest.fixture(scope="module")
def barista(tmp_path_factory: pytest.TempPathFactory) -> Recognizer:
    return recognizer_of(LIST, tmp_path_factory.mktemp("barista"))


@functools.cache
def loud_part(text: str) -> Samples:
    """A text without the silence around it."""
    speech = spoken(text, "cmu_us_slt_arctic_hts").astype(float)
    loud = np.flatnonzero(np.abs(speech) > 0.01 * np.abs(speech).max())
    part = speech[loud[0] : loud[-1]]
    return (part / np.abs(part).max() * 15_000).astype(np.int16)


def stream(*parts: str | float) -> Samples:
    """Texts and the pauses between them, s."""
    whole = [
        loud_part(part) if isinstance(part, str) else np.zeros(int(part * SAMPLE_RATE))
        for part in (1.0, *parts, 2.0)
    ]
    floor = np.random.default_rng(0).normal(0, 8, sum(map(len, whole)))
    return (np.concatenate(whole) + floor).astype(np.int16)


def heard(recognizer: Recognizer, samples: Samples) -> list[Utterance]:
    return list(recognizer.utterances([samples], ""))


@pytest.mark.parametrize("begun", ["make me mocha", "make me an iced"])
def test_an_order_said_in_two_breaths_is_one(begun: str, barista: Recognizer) -> None:
    rest = "with brown sugar" if begun.endswith("mocha") else "coffee"
    for pause in (0.3, BREATH):
        [order] = heard(barista, stream(begun, pause, rest))
        assert (order.text, order.accepted) == (f"{begun} {rest}", True)
        assert order.end - order.start > pause


def test_what_is_said_later_is_no_part_of_an_order(barista: Recognizer) -> None:
    first, *others = heard(barista, stream("make me mocha", 1.2, "with brown sugar"))
    assert (first.text, first.accepted) == ("make me mocha", True)
    assert not any(other.accepted for other in others)


@pytest.mark.parametrize("pause", [BREATH, 0.55])
def test_stop_after_an_order_is_none_of_it(pause: float, barista: Recognizer) -> None:
    samples = stream("make me mocha", pause, "stop")
    order, stop = heard(barista, samples)
    assert [order.text, stop.text] == ["make me mocha", "stop"]
    assert order.accepted
    assert stop.accepted
    alone = heard(barista, stream("stop"))[-1]
    assert stop.t - stop.end <= alone.t - alone.end + 0.01


def test_only_what_may_be_added_to_waits_for_more(barista: Recognizer) -> None:
    waited = {}
    for text in ("make me mocha", "make me mocha with brown sugar", "set servo two to twenty"):
        [said] = heard(barista, stream(text))
        assert (said.text, said.accepted) == (text, True)
        waited[text] = said.t - said.end
    assert waited.pop("make me mocha") > 0.6
    assert max(waited.values()) < 0.4


def test_half_an_order_is_not_obeyed_if_its_rest_is_in_doubt(tmp_path: Path) -> None:
    listed = LIST.replace("brown sugar | almond milk", "beer | deer | gear")
    unsure = recognizer_of(listed, tmp_path)
    [order] = heard(unsure, stream("make me mocha", BREATH, "with near"))
    assert (order.accepted, order.reason) == (False, "unsure_between")


def test_half_an_order_is_not_obeyed_if_its_rest_is_too_soft_to_stand_out(
    barista: Recognizer, monkeypatch: pytest.MonkeyPatch
) -> None:
    samples = stream("make me mocha", BREATH, "with brown sugar")
    until = len(stream("make me mocha")) - int((2.0 - BREATH) * SAMPLE_RATE)
    following = open_stream(barista, "")
    events = list(following.feed(samples[:until]))
    monkeypatch.setattr(segmenter, "BEGIN_ABOVE", 99.0)
    events += [*following.feed(samples[until:]), *following.finish()]
    [order] = [event for event in events if isinstance(event, Utterance)]
    assert (order.accepted, order.reason) == (False, "part_of_a_command")
