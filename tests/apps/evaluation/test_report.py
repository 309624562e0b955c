from __future__ import annotations

import json
import os
import platform
from pathlib import Path

import pytest

from voz.apps.evaluation import report
from voz.apps.evaluation.report import machine
from voz.apps.evaluation.results import Result
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
