"""What the tests of the command share."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import pytest


@pytest.fixture
def own_commands(tmp_path: Path) -> Path:
    path = tmp_path / "lm" / "comandos_voz.txt"
    path.parent.mkdir()
    path.write_text("# for my arm\nOpen Gripper\r\ngo back\nstop\n")
    return path


@pytest.fixture
def here(voz: Any, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """The folder in which the command is called, after the fixture that goes to another."""
    monkeypatch.chdir(tmp_path)
    return tmp_path
