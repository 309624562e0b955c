"""Clips are recognized in their noise; what was heard belongs to the stretch where it is."""

from __future__ import annotations

import os
import signal
from pathlib import Path

import numpy as np
import pytest
import soundfile
from hypothesis import given
from hypothesis import strategies as st
from msgspec.structs import replace
from recordings import FIXTURES

from voz.apps.evaluation import noise
from voz.apps.evaluation.engines import EngineChoice
from voz.apps.evaluation.recognition_tasks import (
    Task,
    assign_to_stretches,
    in_processes,
    prepared,
    recognize,
    recognize_all,
    seconds_outside,
    tasks_for,
)
from voz.apps.evaluation.results import Understood
from voz.apps.recordings.manifest import Clip, read_manifest
from voz.config import Recognition
from voz.errors import ConfigError
from voz.language.language_files import LanguageFiles


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


@pytest.fixture
def voz(language: LanguageFiles) -> EngineChoice:
    return EngineChoice("voz", language, Recognition())


def clip_of(clips: list[Clip], name: str) -> Clip:
    return next(c for c in clips if c.path.stem == name)


@pytest.fixture
def stream(clips: list[Clip], tmp_path: Path) -> list[Clip]:
    """Three that were said in a stream, one after the other, and one that nobody knows of."""
    names = ["festival_slt__go_back", "festival_slt__turn_left", "festival_slt__hello_robot"]
    said, at = [], 1.0
    samples = np.random.default_rng(0).standard_normal(16 * 16000) * 5
    for name in [*names, "festival_slt__stop"]:
        clip = clip_of(clips, name)
        spoken, _ = prepared(Task((clip,)))
        start = round(at * 16000)
        samples[start : start + len(spoken)] += spoken
        end = at + len(spoken) / 16000
        where = {"file": "stream.wav", "path": tmp_path / "stream.wav", "start": at, "end": end}
        said.append(replace(clip, set="mine", **where))
        at += 4
    soundfile.write(tmp_path / "stream.wav", samples.astype(np.int16), 16000)
    return said[:3]


def test_what_is_said_alone_is_also_heard_in_noise(
    clips: list[Clip], stream: list[Clip], hum: Path
) -> None:
    command = next(c for c in clips if c.kind == "command")
    near_miss = next(c for c in clips if c.kind == "near-miss")
    several = next(c for c in clips if c.kind == "long")
    tasks = tasks_for([command, several, *stream, near_miss], [hum], [20, 5], room=True)
    assert [(t.clips, t.snr) for t in tasks] == [
        ((command,), None),
        ((command,), 20),
        ((command,), 5),
        ((several,), None),
        (tuple(stream), None),
        ((near_miss,), None),
        ((near_miss,), 20),
        ((near_miss,), 5),
    ]
    assert all(t.room for t in tasks)


def test_each_stretch_of_a_stream_is_told_what_was_heard_in_it(
    stream: list[Clip], voz: EngineChoice
) -> None:
    go_back, turn_left, hello, rest = recognize(Task(tuple(stream)), voz)
    assert [go_back.obeyed, turn_left.obeyed, hello.obeyed] == [["go back"], ["turn left"], []]
    assert go_back.is_right_and_accepted
    assert (go_back.start, go_back.seconds) == (1, round(stream[0].end - 1, 3))
    assert (rest.kind, rest.obeyed, rest.file) == ("out-of-nothing", ["stop"], "stream.wav")
    said = sum(result.seconds for result in (go_back, turn_left, hello))
    assert rest.seconds == pytest.approx(16 - said, abs=0.01)
    assert go_back.cpu == turn_left.cpu > 0


def test_a_stream_that_is_over_too_early_is_an_error_of_all_of_it(
    stream: list[Clip], voz: EngineChoice
) -> None:
    late = replace(stream[1], start=16.0, end=17.0)
    results = recognize(Task((stream[0], late)), voz)
    assert [result.heard for result in results] == [(), ()]
    assert all("is over after 16.0 s" in (result.error or "") for result in results)


def test_a_command_has_to_be_found_in_noise_that_goes_on(
    clips: list[Clip], voz: EngineChoice, hum: Path
) -> None:
    clip = clip_of(clips, "festival_slt__go_back")
    command, rest = recognize(Task((clip,), noise=(hum,), snr=20), voz)
    assert (command.obeyed, command.noise, command.snr) == (["go back"], "hum", 20)
    (heard,) = command.heard
    assert noise.NOISE_BEFORE < heard.start < heard.end < noise.NOISE_BEFORE + command.seconds
    assert (rest.kind, rest.heard, rest.noise, rest.snr) == ("out-of-nothing", (), "hum", 20)
    assert rest.seconds == noise.NOISE_BEFORE + noise.NOISE_AFTER


def test_who_takes_a_stream_for_one_utterance_has_heard_the_first(
    stream: list[Clip], plain: EngineChoice
) -> None:
    first, *others = recognize(Task(tuple(stream)), plain)
    assert len(first.texts) == 1
    assert [result.texts for result in others] == [[], [], []]


def test_a_clip_is_prepared_the_same_way_each_time(clips: list[Clip], hum: Path) -> None:
    clean, room = Task((clips[0],)), Task((clips[0],), room=True)
    noisy = Task((clips[0],), room=True, noise=(hum, hum), snr=10)
    assert np.array_equal(prepared(noisy)[0], prepared(noisy)[0])
    around = round(16000 * (noise.NOISE_BEFORE + noise.NOISE_AFTER))
    lengths = [len(prepared(task)[0]) for task in (clean, room, noisy)]
    assert np.diff(lengths).tolist() == [6400, around]


def test_what_a_result_holds(clips: list[Clip], plain: EngineChoice) -> None:
    clip = next(c for c in clips if c.file.endswith("festival_slt__go_back.flac"))
    (result,) = recognize(Task((clip,)), plain)
    assert result.texts == ["go back"]
    assert (result.set, result.file, result.speaker) == (clip.set, clip.file, clip.speaker)
    assert result.seconds == round(soundfile.info(clip.path).duration, 3)
    assert 0 < result.cpu < 5
    assert result.error is None


def test_silent_noise_is_an_error_of_the_clip(
    clips: list[Clip], plain: EngineChoice, tmp_path: Path
) -> None:
    soundfile.write(tmp_path / "silent.wav", np.zeros(16000), 16000)
    silent = (tmp_path / "silent.wav",)
    (result,) = recognize(Task((clips[0],), noise=silent, snr=10), plain)
    assert result.error is not None
    assert "silent.wav: is silent" in result.error


@pytest.mark.slow
def test_many_processes_give_results_in_order(
    clips: list[Clip], plain: EngineChoice, tmp_path: Path
) -> None:
    missing = Clip("x", "none.wav", tmp_path / "none.wav", "stop", "me", "command", "all")
    tasks = [Task((clip,)) for clip in [*clips[:5], missing, *clips[5:8]]]
    results = [result for of_task in recognize_all(tasks, plain, 2) for result in of_task]
    assert [r.file for r in results] == [t.clips[0].file for t in tasks]
    (failed,) = [r for r in results if r.error]
    assert failed.error == f"{missing.path}: there is no such file"
    assert failed.heard == ()


def _killed_by_two(item: int) -> int:
    if item == 2:
        os.kill(os.getpid(), signal.SIGKILL)
    return item * item


@pytest.mark.slow
def test_what_two_workers_die_of_costs_nothing_else() -> None:
    squares = in_processes(_killed_by_two, range(6), 2, lambda item, how: f"{item}: {how}")
    assert list(squares) == [0, 1, "2: killed by signal 9", 9, 16, 25]
    with pytest.raises(ConfigError, match="ended twice"):
        list(in_processes(_killed_by_two, range(6), 2))


@pytest.mark.slow
def test_a_clip_that_kills_its_worker_is_an_error(
    clips: list[Clip], plain: EngineChoice, tmp_path: Path
) -> None:
    tasks = [Task((clip,)) for clip in clips[:5]]
    sizes = [44 + 2 * len(prepared(task)[0]) for task in tasks]
    program = tmp_path / "kills.sh"
    program.write_text(f'[ $(stat -c %s "$1") = {sizes[2]} ] && kill -9 $PPID; echo stop\n')
    choice = EngineChoice(f"command:sh {program}", plain.language, plain.settings)
    results = [result for of_task in recognize_all(tasks, choice, 2) for result in of_task]
    assert sizes.count(sizes[2]) == 1
    errors = [result.error for result in results]
    said = f"{clips[2].path}: made its worker end twice (killed by signal 9); use --jobs 1"
    assert errors == [None, None, said, None, None]
    assert [result.texts for result in results if not result.error] == [["stop"]] * 4


def heard(start: float, end: float) -> Understood:
    return Understood("stop", 1.0, accepted=True, start=start, end=end)


@pytest.mark.parametrize(
    ("start", "end", "belongs"),
    [
        (1.2, 1.8, 0),
        (0.0, 9.0, 0),  # a whole recording taken for one utterance
        (0.5, 1.1, 0),
        (1.9, 2.5, 0),
        (1.9, 4.5, 0),
        (2.0, 4.0, None),  # touches both
        (3.9, 4.1, 1),
        (6.0, 7.0, None),
    ],
)
def test_an_utterance_belongs_to_the_first_stretch_that_it_overlaps(
    start: float, end: float, belongs: int | None
) -> None:
    utterance = heard(start, end)
    parts, rest = assign_to_stretches([utterance], [(1.0, 2.0), (4.0, 5.0)])
    assert parts == [[utterance] if n == belongs else [] for n in range(2)]
    assert rest == ([] if belongs is not None else [utterance])


TIMES = st.tuples(st.integers(0, 30), st.integers(1, 9)).map(lambda t: (t[0], t[0] + t[1]))


@given(st.lists(TIMES, max_size=8, unique=True), st.lists(TIMES, max_size=8))
def test_nothing_is_lost_and_the_order_of_the_list_does_not_matter(
    stretches: list[tuple[int, int]], utterances: list[tuple[int, int]]
) -> None:
    said = [heard(*times) for times in utterances]
    parts, rest = assign_to_stretches(said, stretches)
    backwards, same_rest = assign_to_stretches(said, stretches[::-1])
    assert backwards[::-1] == parts
    assert same_rest == rest
    assert sorted(u.start for u in said) == sorted(u.start for p in [*parts, rest] for u in p)


@given(st.lists(TIMES, max_size=8))
def test_the_time_outside_is_what_no_stretch_covers(stretches: list[tuple[int, int]]) -> None:
    covered = {second for start, end in stretches for second in range(start, end)}
    assert seconds_outside(stretches, 25) == sum(n not in covered for n in range(25))
