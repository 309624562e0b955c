"""Recordings of people who name pictures, brought into the form that teaching reads."""

from __future__ import annotations

import csv
import subprocess
from pathlib import Path

import pytest
import soundfile
from recordings import ROOT
from training_programs import in_training

PROGRAM = ROOT / "training" / "stamps.py"

SAID = {"house": "la casa", "boat": "el barco", "tree": "el abeto", "coin": "el queso"}
"""What a voice says of each picture; the text of the last is another one."""

WRITTEN = SAID | {"coin": "una bicicleta muy grande"}


def stamp(folder: Path, name: str) -> None:
    """A picture's texts, and its recording in Spanish."""
    wav = folder / "said.wav"
    subprocess.run(["espeak-ng", "-v", "es", "-w", wav, SAID[name]], check=True)
    sound, rate = soundfile.read(wav)
    soundfile.write(folder / f"{name}_desc_es.ogg", sound, rate)
    texts = f"A {name}.\nes.utf8={WRITTEN[name].capitalize()}.\nfr.utf8=Rien.\n"
    (folder / f"{name}.txt").write_text(texts, encoding="utf-8")


@pytest.mark.slow
def test_what_is_read_as_it_is_written_is_kept_with_its_phones(tmp_path: Path) -> None:
    for name in SAID:
        stamp(tmp_path, name)
    done = in_training(PROGRAM, tmp_path / "out", tmp_path)
    assert done.returncode == 0, done.stderr
    with (tmp_path / "out" / "manifest.tsv").open(encoding="utf-8", newline="") as file:
        rows = list(csv.DictReader(file, delimiter="\t"))
    phones = {row["text"].lower(): row["phones"] for row in rows}
    assert phones.keys() == {"la casa", "el barco", "el abeto"}
    assert phones["la casa"] == "l a k a s a"
    for row in rows:
        sound, rate = soundfile.read(tmp_path / "out" / row["path"])
        assert rate == 16_000
        assert abs(len(sound) / rate - float(row["seconds"])) < 0.01
        assert row["speaker"] == "stamps-es"


def test_a_folder_without_recordings_is_one_line(tmp_path: Path) -> None:
    done = in_training(PROGRAM, tmp_path / "out", tmp_path)
    assert done.returncode == 2
    assert done.stderr.strip().endswith("has no recordings such as owl_desc_es.ogg")
