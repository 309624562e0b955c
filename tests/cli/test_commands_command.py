"""`voz commands`: what may be said, in a terminal and on a page."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import pytest
from recordings import ROOT

from voz.language.build import build


def test_the_list_in_use_is_shown_and_becomes_a_page(
    voz: Any, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    shown = voz("commands")
    assert "  go forward      drives forward at 0.1 m/s\n" in shown.out
    for name in ("commands.txt", "voz.toml"):
        (tmp_path / name).write_bytes((ROOT / "examples" / "drone" / name).read_bytes())
    build(tmp_path / "commands.txt", tmp_path / "lm")
    made = voz("commands", "--card")
    assert made.err.endswith("written: commands.html; open it in a browser and print it\n")
    page = (tmp_path / "commands.html").read_text()
    assert "<strong>stop</strong>" in page
    assert "turn <i>side</i> <i>angle</i> degrees" in page
    assert "<dd>15 to 180, by 15</dd>" in page
    refused = voz("commands", "--card", "--out", "commands.txt")
    assert refused.code == 2
    assert "commands.txt: " in refused.err
    (tmp_path / "lm" / "comandos_voz.templates").unlink()
    assert "does not tell from which list" in voz("commands", "--lm", "lm").err
