"""The program that makes the network's weights, in the environment that has PyTorch."""

from __future__ import annotations

import csv
from pathlib import Path

import numpy as np
import pytest
import soundfile
from recordings import ROOT, Recording
from training_programs import in_training

from voz.language.phones import known_phones
from voz.recognition.network.phoneme_network import (
    DEFAULT_NETWORK,
    OTHER_LANGUAGES,
    PhonemeNetwork,
    read_network,
)

pytestmark = pytest.mark.slow

TEXTS = ("go forward", "rotate left", "speed up", "turn right")

TEACH = ROOT / "training" / "teach.py"

FOREIGN_WORDS = ROOT / "training" / "foreign_words.py"

SAME_BATCH = """
import sys
import torch
from pathlib import Path
sys.path.insert(0, {folder!r})
import numpy as np
from network import Network
from speech import load_pools
from teach import Run, all_phones, make_batch
from voz.recognition.network.phoneme_network import DEFAULT_NETWORK, read_network, write_network
torch.set_num_threads(1)
weights, description, _ = read_network(DEFAULT_NETWORK)
pool, _ = load_pools([Path({speech!r})])
phones = all_phones(description.symbols, pool, torch.device("cpu"))
out = Path({out!r})
run = Run(Network(weights), Network(weights), phones, pool, out, description)
batch = make_batch(pool, 4, np.random.default_rng(0))
rng = np.random.default_rng(1)
print(*(sum(run.learn(batch, 4e-4, rng)) for _ in range(20)))
write_network(out / "taught.npz", run.student.weights(), description)
with torch.no_grad():
    np.save(out / "heard.npy", Network(read_network(out / "taught.npz").weights)(batch.noisy[:1]))
np.save(out / "samples.npy", batch.noisy[0])
"""


@pytest.fixture
def speech(tmp_path: Path, recordings: list[Recording]) -> Path:
    """A folder of speech: each voice of the fixtures is a speaker, and one of them is held back."""
    folder = tmp_path / "speech"
    folder.mkdir()
    voices = sorted({r.voice for r in recordings if r.kind == "command"})
    speakers = {voice: f"speaker-{number}" for number, voice in enumerate(voices)}  # 7 is held back
    with (folder / "manifest.tsv").open("w", newline="") as file:
        table = csv.writer(file, delimiter="\t", lineterminator="\n")
        table.writerow(("path", "text", "speaker", "seconds"))
        for r in recordings:
            if r.path.parent.name == "commands" and r.text in TEXTS:
                seconds = len(r.samples()) / 16000
                table.writerow((r.path, r.text, speakers[r.voice], f"{seconds:.2f}"))
    return folder


def test_twenty_steps_lower_the_loss_and_numpy_computes_what_was_written(
    speech: Path, tmp_path: Path
) -> None:
    program = SAME_BATCH.format(folder=str(TEACH.parent), speech=str(speech), out=str(tmp_path))
    done = in_training("-c", program)
    assert done.returncode == 0, done.stderr
    losses = [float(loss) for loss in done.stdout.split()]
    assert len(losses) == 20
    assert losses[-1] < 0.8 * losses[0]
    before, after = (read_network(file) for file in (DEFAULT_NETWORK, tmp_path / "taught.npz"))
    assert not np.array_equal(before.weights["last.weight"], after.weights["last.weight"])
    assert np.array_equal(before.weights["bands"], after.weights["bands"])
    samples = np.round(np.load(tmp_path / "samples.npy") * 32768)
    ours = PhonemeNetwork(tmp_path / "taught.npz").log_probabilities(samples)
    theirs = np.load(tmp_path / "heard.npy")[0]
    assert np.exp(ours) == pytest.approx(np.exp(theirs), abs=0.02)


def test_a_run_that_was_interrupted_goes_on_and_keeps_the_best(
    speech: Path, tmp_path: Path
) -> None:
    out = tmp_path / "out"
    arguments = ("--speech", speech, "--batch", 2, "--check-every", 2)
    for steps in (2, 4):
        done = in_training(TEACH, out, *arguments, "--steps", steps)
        assert done.returncode == 0, done.stderr
    rows = [line.split("\t") for line in (out / "log.tsv").read_text().splitlines()]
    assert [int(row[1]) for row in rows] == [0, 2, 4]
    assert "best" in rows[0]
    taught = read_network(out / "best.npz")
    assert taught.description.origin.startswith(read_network(DEFAULT_NETWORK).description.origin)


def test_other_languages_teach_the_upper_blocks_alone(speech: Path, tmp_path: Path) -> None:
    foreign = tmp_path / "foreign"
    done = in_training(FOREIGN_WORDS, foreign, "--engine", "pico", "--clips", 12)
    assert done.returncode == 0, done.stderr
    with (foreign / "manifest.tsv").open(newline="", encoding="utf-8") as file:
        rows = list(csv.DictReader(file, delimiter="\t"))
    assert len(rows) > 8
    for row in rows:
        assert row["speaker"].startswith(f"pico-{row['language']}")
        assert known_phones().issuperset(row["phones"].split())
        assert soundfile.info(foreign / row["path"]).samplerate == 16000
    out = tmp_path / "out"
    folders = ("--speech", speech, "--speech", foreign)
    sizes = ("--batch", 2, "--check-every", 4, "--steps", 4, "--first-block", 3)
    done = in_training(TEACH, out, *folders, *sizes)
    assert done.returncode == 0, done.stderr
    with np.load(out / "best.npz") as written:
        assert {name.split(".")[0] for name in written} == {"blocks", "last", "description"}
        assert {name.split(".")[1] for name in written if name.startswith("blocks")} == {"3"}
    assert PhonemeNetwork(out / "best.npz").log_probabilities(np.zeros(16000, np.int16)).any()
    # The best of that run lacks what lies below its block 3, and may go on above it, not below.
    more = ("--start", out / "best.npz", "--batch", 2, "--steps", 1)
    done = in_training(TEACH, tmp_path / "on", *folders, *more, "--first-block", 3)
    assert done.returncode == 0, done.stderr
    PhonemeNetwork(tmp_path / "on" / "best.npz")
    others = ("--start", OTHER_LANGUAGES, "--first-block", 2)
    done = in_training(TEACH, tmp_path / "no", *folders, *others)
    assert done.returncode == 2
    assert "--first-block 2: what lies below it differs from the network of voz" in done.stderr


def test_what_cannot_be_learned_from_is_one_line(tmp_path: Path) -> None:
    done = in_training(TEACH, tmp_path / "out", "--speech", tmp_path / "nowhere")
    assert done.returncode == 2
    assert "nowhere" in done.stderr
    assert "Traceback" not in done.stderr
