from __future__ import annotations

import base64
import io
import re
from html.parser import HTMLParser
from typing import Any

import soundfile

from voz.apps.evaluation import report
from voz.apps.evaluation.failures import Failure, failures
from voz.apps.evaluation.page import MOST_LISTED_FAILURES, to_html
from voz.apps.evaluation.plots import pictures
from voz.apps.evaluation.report import Evaluation
from voz.apps.evaluation.results import Result
from voz.events import to_json

EVIL = '<script>alert("x")</script>'


class Page(HTMLParser):
    """Collects what a page would load, and the elements that are open."""

    def __init__(self) -> None:
        super().__init__()
        self.tags: list[str] = []
        self.loads: list[str] = []

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        self.tags.append(tag)
        self.loads += [v for name, v in attrs if v and name in ("href", "src", "xlink:href")]


def page_of(evaluation: Evaluation, sounds: dict[Failure, bytes] | None = None) -> str:
    drawn = pictures(evaluation.curves, evaluation.scores.commands)
    return to_html(evaluation, {title: p.svg for title, p in drawn.items()}, sounds or {})


def flac() -> bytes:
    file = io.BytesIO()
    soundfile.write(file, [0.0, 0.5] * 800, 16000, format="FLAC")
    return file.getvalue()


def test_the_page_needs_nothing_else(results: list[Result]) -> None:
    sounds = {failures(results)[0]: flac()}
    text = page_of(report.evaluate(results, {"engine": "voz"}), sounds)
    page = Page()
    page.feed(text)
    assert page.tags.count("svg") == 5
    assert page.tags.count("audio") == 1
    assert {"script", "link", "img", "iframe"}.isdisjoint(page.tags)
    inside = ("#", "data:image/png;base64,", "data:audio/flac;base64,")
    assert all(address.startswith(inside) for address in page.loads)
    assert "@import" not in text
    assert all(address.startswith("#") for address in re.findall(r"url\(([^)]*)\)", text))
    (sound,) = re.findall(r"data:audio/flac;base64,([^\"]*)", text)
    assert base64.b64decode(sound) == flac()


def test_the_page_escapes_whatever_the_manifest_says(results: list[Result]) -> None:
    text = page_of(report.evaluate(results, {"engine": EVIL}))
    assert "<script" not in text
    assert text.count("&lt;script&gt;") > 5
    assert "there is no such file" in text


def test_the_page_says_when_where_and_by_what_it_was_made(results: list[Result]) -> None:
    made = ("2026-11-24T07:00:00+00:00", "a computer, 2 cores, Python 3.11.7")
    evaluation = report.evaluate(results, {}, made=made)
    text = page_of(evaluation)
    for said in (evaluation.voz, *made):
        assert f"<td>{said}</td>" in text
    for said in made:
        assert f'"{said}"' in to_json(evaluation)


def rows_of(text: str) -> list[str]:
    listed = text[text.index("What went wrong") :]
    cells = [re.sub(r"<[^>]+>", "|", row) for row in listed.splitlines() if "<td>" in row]
    return [re.sub(r"\|+", "|", row).strip("|") for row in cells]


def test_the_page_lists_what_went_wrong_with_the_worst_first(result: Any) -> None:
    results = [
        result("stop", "stop", file="right"),
        result("stop", "stop?", file="refused", confidence=0.31),
        result("go back", "stop", file="taken", speaker="ann", condition="kitchen"),
        result("stop", "stop", file="loud", snr=5.0, noise="tap"),
        result("go on", "stop", file="far", snr=5.0, noise="tap"),
        result("", "stop", file="x", speaker="x", condition="x", kind="out-of-nothing"),
    ]
    assert rows_of(page_of(report.evaluate(results, {}))) == [
        "obeyed what was not said|go back|stop (0.90)|ann|kitchen|taken",
        "obeyed what was not said|go on|stop (0.90)|me|all, tap, 5 dB|far",
        "obeyed what was not said|(out-of-nothing)|stop (0.90)|0.0 s|x",
        "refused|stop|stop (0.31)|me|all|refused",
    ]


def test_where_all_went_well_the_page_says_so(result: Any) -> None:
    text = page_of(report.evaluate([result("stop", "stop")], {}))
    assert "What went wrong: nothing" in text
    assert rows_of(text) == []


def test_of_very_many_failures_the_page_lists_some_and_says_so(result: Any) -> None:
    results = [result("stop", file=str(number)) for number in range(MOST_LISTED_FAILURES + 7)]
    text = page_of(report.evaluate(results, {}))
    assert len(rows_of(text)) == MOST_LISTED_FAILURES
    assert "What went wrong: 1,007" in text
    assert "And 7 more, which --json lists." in text
