"""A speaker is scored, and trusted more where that pays."""

from __future__ import annotations

import io
import itertools
import math
from collections.abc import Iterator, Sequence
from pathlib import Path

import numpy as np
import pytest
from full_disk import full_disk
from recordings import FIXTURES, GO_BACK, Recording
from rich.console import Console

from voz.api.recognizer import Recognizer
from voz.apps.recordings import calibration
from voz.apps.recordings.calibration import (
    DOUBLINGS,
    PROMPT_COUNT,
    Said,
    Score,
    calibrate,
    check_recording,
    choose_prompts,
    missing_prompts,
    read_saved_recordings,
    record_prompts,
    score,
)
from voz.audio import SAMPLE_RATE, Samples
from voz.audio.sound_files import read_blocks
from voz.errors import ConfigError
from voz.language.language_files import LanguageFiles
from voz.settings import Recognition

ALONE = Recognition(use_network=False)
"""With the network these voices need no more trust."""


@pytest.fixture(scope="module")
def said(recordings: list[Recording]) -> list[Said]:
    """A speaker at a microphone that takes all below 300 and above 3400 Hz away, and tilts."""
    own = [r for r in recordings if r.kind == "command" and r.voice == "flite_slt"]
    return [Said(r.text, telephone(r.samples())) for r in own]


def telephone(plain: Samples) -> Samples:
    frequency = np.fft.rfftfreq(len(plain), 1 / SAMPLE_RATE)
    gain = (((frequency > 300) & (frequency < 3400)) + 0.01) * np.maximum(frequency, 50)
    filtered = np.fft.irfft(np.fft.rfft(plain.astype(float)) * gain, len(plain))
    return (filtered * 0.1 * np.abs(plain).max() / np.abs(filtered).max()).astype(np.int16)


def silence(seconds: float) -> Samples:
    return np.random.default_rng(0).normal(0, 8, int(seconds * SAMPLE_RATE)).astype(np.int16)


def test_each_sentence_is_counted_once_for_what_was_heard(
    recognizer: Recognizer, recordings: list[Recording]
) -> None:
    clips = {r.text: r.samples() for r in recordings if r.voice == "festival_slt"}
    forward, back = clips["go forward"], clips["go back"]
    assert score([Said("go forward", forward)], recognizer) == Score(1, 1, 1, 0)
    assert score([Said("go forward", back)], recognizer) == Score(1, 0, 0, 1)
    assert score([Said("go forward", silence(2))], recognizer) == Score(1, 0, 0, 0)
    both = np.concatenate([forward, silence(1), back])
    assert score([Said("go forward", both)], recognizer) == Score(1, 0, 0, 1)


def test_scores_of_several_sentences_are_added(
    recognizer: Recognizer, recordings: list[Recording]
) -> None:
    clips = {r.text: r.samples() for r in recordings if r.voice == "festival_slt"}
    some = [Said("go forward", clips["go forward"]), Said("stop", clips["go back"])]
    one, other = (score([sentence], recognizer) for sentence in some)
    assert score(some, recognizer) == tuple(a + b for a, b in zip(one, other, strict=True))


@pytest.mark.parametrize(
    ("accepted", "wrong", "doublings"),
    [
        ((20, 20, 20), (0, 0, 0), 0),
        ((10, 11, 12), (0, 0, 0), 0),  # one of 20 is what a doubling costs
        ((10, 12, 12), (0, 0, 0), 1),
        ((10, 12, 14), (0, 0, 0), 2),
        ((10, 12, 14), (0, 0, 3), 1),
        ((10, 12, 14), (0, 2, 4), 0),
    ],
)
def test_a_speaker_is_trusted_more_only_if_each_doubling_of_the_odds_pays(
    accepted: tuple[int, ...],
    wrong: tuple[int, ...],
    doublings: int,
    language: LanguageFiles,
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    scores = [Score(20, 20, *each) for each in zip(accepted, wrong, strict=True)]
    following = iter(scores)
    monkeypatch.setattr(calibration, "score", lambda *_: next(following))
    found = calibrate([Said("stop", silence(1))] * 20, language, ALONE)
    assert found.profile.log_odds == pytest.approx(doublings * math.log(2))
    assert found.profile.model == ("" if doublings else None)
    assert (found.before, found.after) == (scores[0], scores[doublings])


@pytest.mark.slow
def test_a_profile_is_worth_what_it_is_said_to_be(
    said: list[Said], language: LanguageFiles
) -> None:
    steps: list[None] = []
    found = calibrate(said[:6], language, ALONE, lambda: steps.append(None))
    assert len(steps) == len(DOUBLINGS)
    assert found.before == score(said[:6], Recognizer(language, ALONE))
    assert found.after == score(said[:6], Recognizer(language, ALONE, found.profile))


def test_each_command_is_asked_for_and_some_twice_in_the_same_order_each_time() -> None:
    commands = [f"command {number}" for number in range(14)]
    asked = choose_prompts(commands, "ana")
    assert asked == choose_prompts(commands, "ana") != choose_prompts(commands, "juan")
    assert (len(asked), set(asked)) == (PROMPT_COUNT, set(commands))
    assert len(set(choose_prompts([str(n) for n in range(1000)], "ana"))) == PROMPT_COUNT


def test_what_is_recorded_is_not_asked_for_again() -> None:
    nothing = np.zeros(0, np.int16)
    assert missing_prompts(["a", "b", "a", "c"], [Said("a", nothing), Said("c", nothing)]) == [
        "b",
        "a",
    ]


def say(asked: list[str], folder: Path, recognizer: Recognizer, *clips: Path) -> list[str]:
    """Answer by recordings, one after the other and again; gives the lines that are shown."""
    shown = io.StringIO()
    blocks = microphone(clips or [GO_BACK])
    console = Console(file=shown, width=200)
    record_prompts(asked, blocks, recognizer, folder=folder, name="ana", console=console)
    return [" ".join(line.split()) for line in shown.getvalue().splitlines()]


def microphone(clips: Sequence[Path]) -> Iterator[Samples]:
    for clip in itertools.cycle(clips):
        yield from read_blocks(clip)
        yield np.zeros(2 * SAMPLE_RATE, np.int16)


def test_what_is_heard_is_shown_and_what_is_heard_wrongly_is_asked_for_once_more(
    tmp_path: Path, recognizer: Recognizer
) -> None:
    speech = [GO_BACK.with_name(f"festival_slt__{n}_speech.flac") for n in ("start", "stop")]
    other = FIXTURES / "near_misses" / "espeak_us__speed_limit.flac"
    said = [GO_BACK, other, GO_BACK, *speech]
    assert say(["go back", "go back", "start speech"], tmp_path, recognizer, *said) == [
        "1 of 3 say: go back",
        "heard: go back",
        "2 of 3 say: go back",
        "heard: speed up (unsure); say again: go back",
        "heard: go back",
        "3 of 3 say: start speech",
        "heard: start speech",
    ]
    assert len(list(tmp_path.glob("*.flac"))) == 3
    assert say(["go back"], tmp_path / "other", recognizer, *speech) == [
        "1 of 1 say: go back",
        "heard: start speech; say again: go back",
        "heard: stop speech; kept as it is",
    ]
    (kept,) = read_saved_recordings(tmp_path / "other", ["go back"])
    assert check_recording("go back", kept.samples, recognizer) == (False, "stop speech")


def test_a_recording_never_takes_the_place_of_another(
    tmp_path: Path, recognizer: Recognizer
) -> None:
    say(["start speech", "stop", "go forward"], tmp_path, recognizer)
    first, *others = sorted(tmp_path.glob("*.flac"))
    before = {path: path.read_bytes() for path in others}
    manifest = tmp_path / "manifest.tsv"
    header, _, *rest = manifest.read_text().splitlines()
    manifest.write_text("\n".join([header, *rest]))  # as an editor may, without a last newline
    first.unlink()
    say(["go back"], tmp_path, recognizer)
    texts = [
        said.text for said in read_saved_recordings(tmp_path, ["stop", "go forward", "go back"])
    ]
    assert texts == ["stop", "go forward", "go back"]
    assert {path: path.read_bytes() for path in others} == before


def test_recordings_that_cannot_be_written_are_one_line_and_nothing(
    tmp_path: Path, recognizer: Recognizer
) -> None:
    say(["stop"], tmp_path, recognizer)
    before = sorted(tmp_path.iterdir())
    with full_disk(1000), pytest.raises(ConfigError, match=r"cannot be written \(File too large\)"):
        say(["go back"], tmp_path, recognizer)
    assert sorted(tmp_path.iterdir()) == before
