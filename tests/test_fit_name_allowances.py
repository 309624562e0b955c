"""The tool that measures anew what each phone counts for, on a few recordings as talk."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest
from fit_name_allowances import PHONES, fit, reached
from recordings import FIXTURES, ROOT

from voz.recognition import robot_name
from voz.recognition.robot_name import read_allowances


def test_a_few_recordings_give_a_table_that_voz_reads(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    manifest, table = tmp_path / "talk.tsv", tmp_path / "allowances.tsv"
    commands = ("go_back", "turn_left", "speed_up", "fold_arm", "slow_down", "rotate_right")
    lines = [
        f"{FIXTURES / 'commands' / f'festival_slt__{name}.flac'}\t{name}\tfestival_slt\ttalk\n"
        for name in commands
    ]
    manifest.write_text("file\ttext\tvoice\tkind\n" + "".join(lines))
    tool = [sys.executable, ROOT / "tools" / "fit_name_allowances.py", manifest]
    options = ["--coverage", "2", "--out", table]
    done = subprocess.run(
        [*tool, *options], check=True, timeout=300, capture_output=True, text=True
    )
    assert "the average name" in done.stdout
    usual = read_allowances()
    monkeypatch.setattr(robot_name, "ALLOWANCES_FILE", table)
    found = read_allowances()
    assert found.keys() == usual.keys()
    assert found != usual
    assert sum(found.values()) > 0


def test_what_each_phone_counts_for_follows_from_the_scores_of_words() -> None:
    random = np.random.default_rng(1)
    counts = random.poisson(0.2, (2000, len(PHONES))).astype(float)
    allowances = random.uniform(1, 5, len(PHONES))
    start, found = fit(counts, 7 - counts @ allowances)
    assert start == pytest.approx(7, abs=0.3)
    np.testing.assert_allclose(found, allowances, atol=0.3)


def test_a_score_that_is_reached_seldom_follows_from_those_that_are_reached_often() -> None:
    random = np.random.default_rng(1)
    hours, pieces = 5.0, 4000
    scores = -20 + 2.5 * np.log(1 / random.uniform(size=(pieces, 200)))
    expected = -20 + 2.5 * np.log(pieces / (0.1 * hours))
    assert reached(scores, hours).mean() == pytest.approx(expected, abs=0.5)
