"""The command as the tests call it."""

from __future__ import annotations

import signal
from collections.abc import Callable
from pathlib import Path

import pytest
from calls import Result
from recordings import ROOT

from voz.cli import main


@pytest.fixture
def voz(
    capfd: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> Callable[..., Result]:
    """Call the command in this process: ten times faster than in one of its own."""
    monkeypatch.setattr(signal, "signal", lambda *_: None)  # pytest's own stay
    monkeypatch.chdir(ROOT)

    def call(*arguments: object) -> Result:
        capfd.readouterr()
        code = main([str(argument) for argument in arguments])
        return Result(code, *capfd.readouterr())

    return call


@pytest.fixture
def own_commands(tmp_path: Path) -> Path:
    path = tmp_path / "lm" / "comandos_voz.txt"
    path.parent.mkdir()
    path.write_text("# for my arm\nOpen Gripper\r\ngo back\nstop\n")
    return path
