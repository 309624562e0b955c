"""`benchmarks/language.py` as it is called, on a language made for it and with one voice."""

from __future__ import annotations

import re
import subprocess
import sys
from pathlib import Path

import pytest
from recordings import ROOT
from spanish import spanish


@pytest.mark.slow
def test_what_is_right_and_what_is_refused_is_told_for_each_threshold(tmp_path: Path) -> None:
    spanish(tmp_path)
    script = ROOT / "benchmarks" / "language.py"
    command = [sys.executable, str(script), str(tmp_path), "--voices", "1", "--all"]
    done = subprocess.run(command, capture_output=True, text=True)
    assert done.returncode == 0, done.stderr
    assert "; 1 of 12 voices; accepted from 0." in done.stdout
    (right, said), (refused, others) = (
        [int(number) for number in re.findall(r"\d+", line)[:2]]
        for line in re.findall("^(?:commands|near-misses): .*", done.stdout, re.MULTILINE)
    )
    assert (said, others) == (14, 20)
    assert right >= 12
    found = re.findall(r"at threshold 0.\d: (\d+) right and accepted, (\d+) near", done.stdout)
    kept, more = ([int(number) for number in column] for column in zip(*found, strict=True))
    assert len(kept) == 5
    assert right >= kept[0] > 0
    assert kept == sorted(kept, reverse=True)
    assert more == sorted(more)
    wrong = re.findall(r"^.*: .* 0\.\d+ accepted$", done.stdout, re.MULTILINE)
    assert len(wrong) == others - refused  # of the commands, none is taken for another
