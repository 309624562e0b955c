from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
import soundfile
from recordings import FIXTURES

from voz.config import Recognition
from voz.evaluation.engines import EngineChoice
from voz.evaluation.manifest import read_manifest
from voz.evaluation.recognise import Task, prepared, recognise, recognise_all, tasks_for
from voz.evaluation.results import Clip
from voz.language.files import LanguageFiles


@pytest.fixture(scope="module")
def clips() -> list[Clip]:
    return read_manifest(FIXTURES / "manifest.tsv")


@pytest.fixture
def plain(language: LanguageFiles) -> EngineChoice:
    return EngineChoice("plain-pocketsphinx", language, Recognition())


@pytest.fixture
def hum(tmp_path: Path) -> Path:
    path = tmp_path / "hum.wav"
    rng = np.random.default_rng(0)
    soundfile.write(path, 0.1 * rng.standard_normal(40000), 16000)
    return path


def test_commands_alone_are_also_heard_in_noise(clips: list[Clip], hum: Path) -> None:
    command = next(c for c in clips if c.kind == "command")
    other = next(c for c in clips if c.kind == "near-miss")
    tasks = tasks_for([command, other], [hum], [20, 5], room=True)
    assert [(t.clip.kind, t.snr) for t in tasks] == [
        ("command", None),
        ("command", 20),
        ("command", 5),
        ("near-miss", None),
    ]
    assert all(t.room for t in tasks)


def test_a_clip_is_prepared_the_same_way_each_time(clips: list[Clip], hum: Path) -> None:
    clean, noisy = Task(clips[0]), Task(clips[0], room=True, noise=(hum, hum), snr=10)
    assert np.array_equal(prepared(noisy), prepared(noisy))
    assert len(prepared(noisy)) == len(prepared(clean)) + 6400
    assert not np.array_equal(prepared(noisy), prepared(Task(clips[0], room=True)))


def test_what_a_result_holds(clips: list[Clip], plain: EngineChoice) -> None:
    clip = next(c for c in clips if c.file.endswith("festival_slt__go_back.flac"))
    result = recognise(Task(clip), plain)
    assert result.texts == ["go back"]
    assert (result.set, result.file, result.speaker) == (clip.set, clip.file, clip.speaker)
    assert result.seconds == round(soundfile.info(clip.path).duration, 3)
    assert 0 < result.cpu < 5
    assert result.error is None


def test_silent_noise_is_an_error_of_the_clip(
    clips: list[Clip], plain: EngineChoice, tmp_path: Path
) -> None:
    soundfile.write(tmp_path / "silent.wav", np.zeros(16000), 16000)
    result = recognise(Task(clips[0], noise=(tmp_path / "silent.wav",), snr=10), plain)
    assert result.error is not None
    assert "silent.wav: is silent" in result.error


@pytest.mark.slow
def test_many_processes_give_results_in_order(
    clips: list[Clip], plain: EngineChoice, tmp_path: Path
) -> None:
    missing = Clip("x", "none.wav", tmp_path / "none.wav", "stop", "me", "command", "all")
    tasks = [Task(clip) for clip in [*clips[:5], missing, *clips[5:8]]]
    results = list(recognise_all(tasks, plain, 2))
    assert [r.file for r in results] == [t.clip.file for t in tasks]
    (failed,) = [r for r in results if r.error]
    assert failed.error == f"{missing.path}: there is no such file"
    assert failed.heard == ()
