"""The program that fits by which sounds a name is known, on a few recordings as words and talk."""

from __future__ import annotations

import pickle
from pathlib import Path

import numpy as np
import pytest
from recordings import FIXTURES, ROOT, Recording
from training_programs import in_training, load_training

from voz.recognition.name import LENGTH_LIMITS, NameEvidence, read_weights

pytestmark = pytest.mark.slow

PROGRAM = ROOT / "training" / "name_weights.py"

PHONES = 39

AS_USED, AS_CHECK = "speaker-0", "speaker-3"
"""Two speakers of talk: by the first the weights are fitted, by the second their threshold."""


@pytest.fixture
def words(tmp_path: Path, recordings: list[Recording]) -> Path:
    folder = tmp_path / "words"
    folder.mkdir()
    chosen = [r for r in recordings if r.path.parent.name == "commands"][::2]
    lines = [f"{r.path}\t{r.text}\t{r.voice}\t{len(r.samples()) / 16000}\n" for r in chosen]
    (folder / "manifest.tsv").write_text("path\ttext\tspeaker\tseconds\n" + "".join(lines))
    return folder


def talk_by(folder: Path, *speakers: str) -> Path:
    manifest = folder / "talk.tsv"
    files = sorted((FIXTURES / "near_misses").glob("*.flac"))
    assert len(files) > 10
    lines = [
        f"{file}\tsome talk\t{speakers[number % len(speakers)]}\ttalk\n"
        for number, file in enumerate(files)
    ]
    manifest.write_text("path\ttext\tspeaker\tkind\n" + "".join(lines))
    return manifest


def test_a_few_recordings_give_weights_that_voz_reads(tmp_path: Path, words: Path) -> None:
    out = tmp_path / "weights.npz"
    talk = talk_by(tmp_path, AS_USED, AS_CHECK)
    done = in_training(PROGRAM, "--speech", words, "--names", 6, "--out", out, talk)
    assert done.returncode == 0, done.stderr
    assert "words in noise are missed" in done.stdout
    found, usual = read_weights(out), read_weights()
    for name, values in usual._asdict().items():
        assert np.shape(getattr(found, name)) == np.shape(values)
    assert found.fit > 0
    assert not np.array_equal(found.heard, usual.heard)


CALLS = f"""
import sys
import typer
sys.path.insert(0, {str(PROGRAM.parent)!r})
from name_weights import main
talk, words, nowhere, folder = sys.argv[1:]
for given in ((words, talk), (nowhere, talk), (words, folder)):
    sys.argv[1:] = ["--speech", *given]
    try:
        typer.run(main)
    except SystemExit as end:
        print(end.code)
"""


def test_speakers_who_are_scored_by_and_what_cannot_be_read_teach_nothing(
    tmp_path: Path, words: Path
) -> None:
    talk = talk_by(tmp_path, "speaker-4", "speaker-5")
    done = in_training("-c", CALLS, talk, words, tmp_path / "nowhere", tmp_path)
    assert done.stdout.split() == ["2", "2", "2"]
    assert "Traceback" not in done.stderr
    assert done.stderr.count("too few speakers of talk") == 1
    assert done.stderr.count("Invalid value") == 3


def made_up(fit: float, mistaken: bool, rng: np.random.Generator) -> NameEvidence:
    """A name of one phone three times, which is heard as the next phone if it is mistaken."""
    heard = np.full((3, PHONES + 1), -4.6)
    heard[:, 7 if mistaken else 6] = 4.6
    phones = np.full(3, 6)
    return NameEvidence(fit, 0.0, 0, 9, phones, heard, rng.integers(len(LENGTH_LIMITS) + 1, size=3))


FIT = f"""
import pickle, sys
from pathlib import Path
sys.path.insert(0, {str(PROGRAM.parent)!r})
from name_weights import examples, fit, with_threshold, with_typical
file = Path(sys.argv[1])
said, other, rooms = pickle.loads(file.read_bytes())
weights = fit(examples(said), examples(other))
moved = with_threshold(weights, rooms, 4.0)
file.write_bytes(pickle.dumps([weights, moved, with_typical(moved, said).typical]))
"""


def test_a_phone_that_is_often_mistaken_counts_little_against_a_name(tmp_path: Path) -> None:
    rng = np.random.default_rng(1)
    said = [made_up(-6.0 * (number % 2), number % 2 == 1, rng) for number in range(400)]
    other = [made_up(-6.0, False, rng) for _ in range(400)]
    nearest = [*other[:100], *said[:4]]
    file = tmp_path / "evidence"
    file.write_bytes(pickle.dumps([said, other, [nearest, other[:9]]]))
    done = in_training("-c", FIT, file)
    assert done.returncode == 0, done.stderr
    weights, moved, typical = pickle.loads(file.read_bytes())
    mistaken = made_up(-6.0, True, rng)
    assert mistaken.log_odds(weights) > 0 > other[0].log_odds(weights)
    assert sum(one.log_odds(moved) > 0 for one in nearest) == 4
    mean = np.mean([one.log_odds(moved) for one in said]) - moved.constant
    assert typical[6] == pytest.approx(mean / 3)


def test_few_words_give_few_names(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.syspath_prepend(ROOT / "training")
    program = load_training("name_examples")
    words = [("S", "T", "AA", "P"), ("F", "OW", "L", "D")]
    assert program.made_up(600, words) == [("F", "OW", "AA", "P"), ("S", "T", "L", "D")]
    assert len(program.made_up(1, words)) == 1
