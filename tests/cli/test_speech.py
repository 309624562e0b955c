"""`voz say`: a text as sound."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import soundfile


def test_say_writes_a_wav(voz: Any, tmp_path: Path) -> None:
    assert voz("say", "hello robot", "--out", tmp_path / "hello.wav").code == 0
    assert soundfile.info(tmp_path / "hello.wav").duration > 0.4


def test_say_lists_the_voices_that_are_installed(voz: Any) -> None:
    assert "kal_diphone" in voz("say", "--list-voices").out.splitlines()
