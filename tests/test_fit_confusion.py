"""The tool that measures the phone distances anew, on two commands of the fixtures."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path

from recordings import FIXTURES, ROOT

from voz.language.phones import read_distances

TOOL = (sys.executable, ROOT / "tools" / "fit_confusion.py")


def test_two_commands_give_a_table_that_voz_reads(tmp_path: Path) -> None:
    manifest, table = tmp_path / "two.tsv", tmp_path / "distances.tsv"
    lines = [
        f"{FIXTURES / 'commands' / f'festival_slt__{name}.flac'}\t{text}\tfestival_slt\tcommand\n"
        for name, text in (("go_back", "go back"), ("turn_left", "turn left"))
    ]
    manifest.write_text("file\ttext\tvoice\tkind\n" + "".join(lines))
    subprocess.run([*TOOL, manifest, "--out", table], check=True, timeout=120)
    found, usual = read_distances(table), read_distances()
    assert found.frames.keys() == usual.frames.keys()
    assert all(row[phone] == 0 < max(row.values()) for phone, row in found.apart.items())
    assert found.apart["B"]["P"] < found.apart["B"]["AE"]
    assert found.frames["AE"] != usual.frames["AE"]  # that of "back" alone
