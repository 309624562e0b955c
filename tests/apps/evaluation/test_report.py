from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import pytest

from voz.apps.evaluation import report
from voz.apps.evaluation.results import Result
from voz.errors import ConfigError
from voz.events import to_json


def test_what_json_writes_can_be_compared_with(results: list[Result], tmp_path: Path) -> None:
    evaluation = report.evaluate(results, {"engine": "voz"})
    saved = tmp_path / "other.json"
    saved.write_text(to_json(evaluation))
    assert report.read_results(saved, in_noise=True) == results
    assert json.loads(saved.read_text())["settings"] == {"engine": "voz"}
    compared = report.evaluate(results, {}, report.read_results(saved, in_noise=True))
    assert [(d.clips, d.this - d.other, d.p) for d in compared.comparison] == [
        (2, 0, 1),
        (1, 0, 1),
        (1, 0, 1),
        (1, 0, 1),
    ]
    assert [(d.kind, d.this.alarms, d.other.alarms) for d in compared.alarm_comparison] == [
        ("talk", 1, 1)
    ]


OLD = """{"voz":"0.1.0","results":[
{"set":"mine","file":"c","text":"stop","speaker":"me","kind":"command","condition":"all","snr":null,
"heard":[{"text":"stop","confidence":0.9,"accepted":true}],"seconds":1.0,"cpu":0.04,"error":null},
{"set":"mine","file":"c","text":"stop","speaker":"me","kind":"command","condition":"all","snr":10.0,
"heard":[{"text":"stop","confidence":0.9,"accepted":true}],"seconds":1.0,"cpu":0.04,"error":null}
]}"""


def test_an_older_evaluation_is_compared_but_for_its_noise(result: Any, tmp_path: Path) -> None:
    path = tmp_path / "old.json"
    path.write_text(OLD)
    quiet, noisy = result("stop", file="c"), result("stop", file="c", snr=10.0, noise="tap")
    others = report.read_results(path, in_noise=False)
    (difference,) = report.evaluate([quiet, noisy], {}, others).comparison
    assert (difference.snr, difference.only_other) == (None, 1)
    with pytest.raises(ConfigError, match=r"old.json: is by an older voz.* compare without --snr"):
        report.read_results(path, in_noise=True)


def test_what_cannot_be_compared_with(results: list[Result], tmp_path: Path) -> None:
    (tmp_path / "other.json").write_text('{"scores": []}')
    with pytest.raises(ConfigError, match="cannot be used"):
        report.read_results(tmp_path / "other.json", in_noise=False)
    with pytest.raises(ConfigError, match="cannot be read"):
        report.read_results(tmp_path / "none.json", in_noise=False)
    with pytest.raises(ConfigError, match="none of these commands"):
        report.evaluate(results, {}, [])


def test_the_terminal_gets_the_main_figures(results: list[Result]) -> None:
    text = report.to_text(report.evaluate(results, {}))
    for words in ("right and accepted", "let through", "per hour", "area under the ROC"):
        assert words in text
    assert report.to_text(report.evaluate([], {})) == ""
