"""`voz run --events`: where the lines go, and what if they cannot."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import pytest

from voz.cli.text_io import event_log
from voz.events import Twist


def test_each_event_is_on_the_disk_at_once(tmp_path: Path) -> None:
    path = tmp_path / "e.jsonl"
    with event_log(str(path)) as receive:
        for t in (0.1, 0.2):
            receive(Twist(t, 0.1, 0.0))
            assert path.read_text().count("\n") == round(10 * t)
    *_, last = path.read_text().splitlines()
    assert last == '{"type":"cmd_vel","t":0.2,"linear":0.1,"angular":0.0}'


@pytest.mark.parametrize("pace", [[], ["--realtime"]])
def test_a_full_disk_is_one_clear_line(pace: list[str], voz: Any, tmp_path: Path) -> None:
    typed = tmp_path / "typed.txt"
    typed.write_text("start speech\ngo forward\n-\n-\n")
    arguments = ["--text", typed, "--no-sound", "--events", "/dev/full"]
    result = voz("run", *arguments, *pace)
    assert result.complaint == "voz: /dev/full: cannot be written (No space left on device)"
    assert "drives" not in result.out
