from __future__ import annotations

import os
import platform
from pathlib import Path

import pytest

from voz.apps.evaluation import machine as of_machine
from voz.apps.evaluation.machine import machine


@pytest.fixture
def told(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    monkeypatch.setattr(of_machine, "CPUINFO", tmp_path / "cpuinfo")
    monkeypatch.setattr(of_machine, "BOARD_MODEL", tmp_path / "model")
    return tmp_path


def test_the_processor_its_cores_and_the_python_are_named(told: Path) -> None:
    rest = f", {os.cpu_count()} cores, Python {platform.python_version()}"
    assert machine() == platform.machine() + rest
    (told / "cpuinfo").write_text("processor\t: 0\nmodel name\t: AMD EPYC\n" * 2)
    assert machine() == "AMD EPYC" + rest
    (told / "model").write_text("Raspberry Pi 5 Model B Rev 1.0\0")
    assert machine() == "Raspberry Pi 5 Model B Rev 1.0" + rest
