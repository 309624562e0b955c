from __future__ import annotations

import base64
import io
import json
import os
import platform
import re
from html.parser import HTMLParser
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import soundfile
from msgspec.structs import replace
from recordings import FIXTURES, GO_BACK

from voz.apps.evaluation import report
from voz.apps.evaluation.plots import pictures
from voz.apps.evaluation.recognition_tasks import Task, prepared
from voz.apps.evaluation.report import (
    LONGEST_SOUND,
    MISHEARD,
    MOST_LISTED_FAILURES,
    MOST_SOUNDS,
    OBEYED,
    REFUSED,
    UNHEARD,
    UNREAD,
    WORST_FIRST,
    Evaluation,
    Failure,
    failures,
    machine,
    sounds_of_failures,
    to_html,
)
from voz.apps.evaluation.results import Result, Understood
from voz.apps.recordings.manifest import Clip
from voz.audio import SAMPLE_RATE, Samples
from voz.errors import ConfigError
from voz.events import to_json


def test_what_json_writes_can_be_compared_with(results: list[Result], tmp_path: Path) -> None:
    evaluation = report.evaluate(results, {"engine": "voz"})
    saved = tmp_path / "other.json"
    saved.write_text(to_json(evaluation))
    assert report.read_results(saved) == results
    assert json.loads(saved.read_text())["settings"] == {"engine": "voz"}
    compared = report.evaluate(results, {}, report.read_results(saved))
    assert [(d.clips, d.this - d.other, d.p) for d in compared.comparison] == [
        (2, 0, 1),
        (1, 0, 1),
        (1, 0, 1),
        (1, 0, 1),
    ]
    assert [(d.kind, d.this.alarms, d.other.alarms) for d in compared.alarm_comparison] == [
        ("talk", 1, 1)
    ]


def test_what_cannot_be_compared_with(results: list[Result], tmp_path: Path) -> None:
    (tmp_path / "other.json").write_text('{"scores": []}')
    with pytest.raises(ConfigError, match="cannot be used"):
        report.read_results(tmp_path / "other.json")
    with pytest.raises(ConfigError, match="cannot be read"):
        report.read_results(tmp_path / "none.json")
    with pytest.raises(ConfigError, match="none of these commands"):
        report.evaluate(results, {}, [])


def test_the_terminal_gets_the_main_figures(results: list[Result]) -> None:
    text = report.to_text(report.evaluate(results, {}))
    for words in ("right and accepted", "let through", "per hour", "area under the ROC"):
        assert words in text
    assert report.to_text(report.evaluate([], {})) == ""


@pytest.fixture
def told(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    monkeypatch.setattr(report, "CPUINFO", tmp_path / "cpuinfo")
    monkeypatch.setattr(report, "BOARD_MODEL", tmp_path / "model")
    return tmp_path


def test_the_processor_its_cores_and_the_python_are_named(told: Path) -> None:
    rest = f", {os.cpu_count()} cores, Python {platform.python_version()}"
    assert machine() == platform.machine() + rest
    (told / "cpuinfo").write_text("processor\t: 0\nmodel name\t: AMD EPYC\n" * 2)
    assert machine() == "AMD EPYC" + rest
    (told / "model").write_text("Raspberry Pi 5 Model B Rev 1.0\0")
    assert machine() == "Raspberry Pi 5 Model B Rev 1.0" + rest


@pytest.mark.parametrize(
    ("said", "heard", "others", "what"),
    [
        ("stop", ["stop"], {}, None),
        ("stop", ["stop?"], {}, REFUSED),
        ("stop", ["go back?"], {}, MISHEARD),
        ("stop", ["go back"], {}, OBEYED),
        ("stop", ["stop", "stop"], {}, MISHEARD),
        ("stop", [], {}, UNHEARD),
        ("stop", ["?"], {}, UNHEARD),
        ("stop", [], {"error": "none.wav: there is no such file"}, UNREAD),
        ("stop | go back", ["stop", "go back"], {"kind": "long"}, None),
        ("stop | go back", ["stop"], {"kind": "long"}, MISHEARD),
        ("stop it", ["stop?"], {"kind": "near-miss"}, None),
        ("stop it", ["stop"], {"kind": "near-miss"}, OBEYED),
        ("la la", ["stop?"], {"kind": "talk"}, None),
        ("", ["stop"], {"kind": "noise"}, OBEYED),
        ("", ["stop"], {"kind": "out-of-nothing"}, OBEYED),
    ],
)
def test_what_went_wrong(
    result: Any, said: str, heard: list[str], others: dict[str, Any], what: str | None
) -> None:
    found = failures([result(said, *heard, **others)])
    assert [failure.what for failure in found] == ([what] if what else [])


def test_in_a_stream_the_stretch_is_named_and_in_talk_what_was_obeyed(result: Any) -> None:
    talk = replace(
        result("", kind="talk"),
        heard=(
            Understood("stop", 0.9, True, 0.2, 1.0),
            Understood("go back", 0.1, False, 3.0, 4.0),
            Understood("go back", 0.8, True, 100.0, 101.0),
        ),
    )
    (first, second, third) = failures([result("stop", start=2.5, end=3.5), talk])
    assert (first.number, first.stretch) == (1, (0.0, 1.5))
    assert second == Failure(1, OBEYED, (talk.heard[2],), (99.5, 101.5))
    assert third == Failure(0, UNHEARD, (), (2.5, 3.5))


def test_the_worst_is_first_and_the_rest_in_its_order(result: Any) -> None:
    results = [
        result("stop", error="unreadable"),
        result("stop"),
        result("stop", "stop?"),
        result("stop", "go back?"),
        result("stop", "go back"),
        result("stop", "turn left"),
    ]
    assert [failure.number for failure in failures(results)] == [4, 5, 3, 2, 1, 0]
    assert [failure.what for failure in failures(results)][1:] == list(WORST_FIRST)


SESSION = FIXTURES / "long" / "session.wav"


def task(path: Path, **noise: object) -> Task:
    return Task((Clip("set", path.name, path, "stop", "me", "command", "all"),), **noise)  # type: ignore[arg-type]


def samples(flac: bytes) -> Samples:
    found: Samples = soundfile.read(io.BytesIO(flac), dtype="int16")[0]
    return found


def test_a_clip_is_whole_and_of_a_stream_the_stretch_is_cut_out() -> None:
    whole = Failure(0, OBEYED, ())
    part, long = Failure(1, OBEYED, (), (2.0, 3.5)), Failure(1, OBEYED, (), (1.0, 999.0))
    found = sounds_of_failures([whole, part, long], [task(GO_BACK), task(SESSION)])
    session, _ = prepared(task(SESSION))
    assert np.array_equal(samples(found[whole]), soundfile.read(GO_BACK, dtype="int16")[0])
    assert np.array_equal(samples(found[part]), session[2 * SAMPLE_RATE : 7 * SAMPLE_RATE // 2])
    assert len(samples(found[long])) == LONGEST_SOUND * SAMPLE_RATE


def test_noise_is_heard_too() -> None:
    noisy = task(GO_BACK, noise=(FIXTURES / "long" / "kitchen.wav",), snr=5.0)
    failure = Failure(0, OBEYED, ())
    found = sounds_of_failures([failure], [noisy])
    assert np.array_equal(samples(found[failure]), prepared(noisy)[0])


def test_what_cannot_be_read_has_no_sound_and_of_many_the_worst_have() -> None:
    missing, good = Failure(0, UNREAD, ()), Failure(1, OBEYED, ())
    tasks = [task(Path("none.wav")), task(GO_BACK)]
    assert list(sounds_of_failures([missing, good], tasks)) == [good]
    many = [Failure(1, OBEYED, (), (0.0, 0.01 * number)) for number in range(1, MOST_SOUNDS + 5)]
    assert list(sounds_of_failures(many, tasks)) == many[:MOST_SOUNDS]


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
