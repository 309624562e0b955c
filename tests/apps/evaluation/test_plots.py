from __future__ import annotations

import xml.etree.ElementTree as ET
from typing import Any

import pytest

from voz.apps.evaluation.curves import confusion, curves
from voz.apps.evaluation.plots import confusion as confusion_picture
from voz.apps.evaluation.plots import noise_lines, pictures
from voz.apps.evaluation.results import Result
from voz.apps.evaluation.scores import score


@pytest.fixture
def results(result: Any) -> list[Result]:
    return [
        result("stop", "stop", confidence=0.9),
        result("go back", "go back", confidence=0.7),
        result("stop", "stop", snr=10.0, noise="tap"),
        result("stop", snr=0.0, noise="tap"),
        result("stop", "stop", snr=0.0, noise="motor"),
        result("stop it", "stop?", confidence=0.4, kind="near-miss"),
    ]


def test_all_pictures_are_svg_and_png_and_the_same_each_time(results: list[Result]) -> None:
    first, again = (pictures(curves(results), score(results).commands) for _ in range(2))
    assert first == again
    assert len(first) == 5
    for picture in first.values():
        assert ET.fromstring(picture.svg).tag == "{http://www.w3.org/2000/svg}svg"
        assert picture.png.startswith(b"\x89PNG")


def test_only_what_there_is_is_drawn(results: list[Result]) -> None:
    assert pictures(curves([]), []) == {}
    (title,) = pictures(curves(results[2:5]), score(results[2:5]).commands)
    assert title == "Commands in noise"
    assert pictures(curves(results[2:3]), score(results[2:3]).commands) == {}


def test_each_noise_has_a_line_and_quiet_a_point(results: list[Result]) -> None:
    lines = noise_lines(score(results).commands)
    ratios = {name: [s.group.snr for s in scores] for name, scores in lines.items()}
    assert ratios == {"quiet": [None], "motor": [0], "tap": [10, 0]}


def test_where_there_are_several_sets_a_line_is_named_after_its_own(result: Any) -> None:
    results = [result("stop", "stop"), result("stop", "stop", set="other", snr=5.0, noise="tap")]
    assert list(noise_lines(score(results).commands)) == ["mine, quiet", "other, tap"]


def test_texts_that_mean_something_to_others_are_only_texts() -> None:
    picture = confusion_picture(confusion([("$x$ < & -->", r"$\bad{$"), ("go", "go")]))
    ET.fromstring(picture.svg)
