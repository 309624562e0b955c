"""What the tests of the command share."""

from __future__ import annotations

from pathlib import Path

import pytest


@pytest.fixture
def own_commands(tmp_path: Path) -> Path:
    path = tmp_path / "lm" / "comandos_voz.txt"
    path.parent.mkdir()
    path.write_text("# for my arm\nOpen Gripper\r\ngo back\nstop\n")
    return path
