"""What is understood of the fixtures, from file to utterance."""

from __future__ import annotations

import asyncio
import math
import subprocess
import sys
from collections.abc import AsyncIterator, Iterator
from functools import cache
from pathlib import Path

import numpy as np
import pytest
from msgspec.structs import replace
from recordings import FIXTURES, GO_BACK, Recording
from synthesis import VOICES, Voice, phrase, with_floor

import voz
from voz.api.recognizer import Recognizer
from voz.audio import SAMPLE_RATE, Samples
from voz.audio.segmenter import segments
from voz.audio.sound_files import read_blocks, read_samples
from voz.errors import AudioError
from voz.events import Partial, Utterance
from voz.language.language_files import LanguageFiles
from voz.recognition.confidence import SCORE, load_models, save_models
from voz.recognition.engine import confidence_model, open_stream
from voz.recognition.network.phoneme_network import UnknownNetworkError
from voz.recognition.thresholds import threshold_for
from voz.settings import Recognition


@cache  # many tests look at the same
def utterances(recognizer: Recognizer, recording: Recording) -> list[Utterance]:
    return list(recognizer.utterances(read_blocks(recording.path), recording.path.name))


def share(values: list[bool]) -> float:
    return float(np.mean(values))


def test_commands_are_accepted_and_most_near_misses_are_not(
    recognizer: Recognizer, recordings: list[Recording]
) -> None:
    def accepted(kind: str) -> float:
        clips = [r for r in recordings if r.kind == kind]
        return share([any(u.accepted for u in utterances(recognizer, r)) for r in clips])

    assert accepted("command") >= 0.9
    assert accepted("near-miss") <= 0.25


def test_a_recognizer_says_its_commands(recognizer: Recognizer) -> None:
    shown = repr(recognizer)
    assert shown.startswith("<Recognizer: start speech, stop speech, go forward")
    assert shown.endswith("fold arm>")
    many = voz.load(["stop", "go to place {number: 1..22}"])
    assert repr(many).endswith(" and 3 more>")


@pytest.mark.parametrize("kind", ["long", "format"])
def test_long_recordings_and_other_formats(
    kind: str, recognizer: Recognizer, recordings: list[Recording]
) -> None:
    for recording in recordings:
        if recording.kind == kind:
            heard = utterances(recognizer, recording)
            assert [u.text for u in heard] == recording.commands


def test_times_are_within_the_recording_and_in_order(
    recognizer: Recognizer, session: Recording
) -> None:
    heard = utterances(recognizer, session)
    times = [t for u in heard for t in (u.start, u.end)]
    assert times == sorted(times)
    assert all(u.start < u.end <= u.t < 23 for u in heard)
    assert {u.source for u in heard} == {"session.wav"}


def test_an_array_without_its_rate_is_taken_for_no_rate(recognizer: Recognizer) -> None:
    told = "an array does not hold its sample rate; give it, as in rate=44100"
    with pytest.raises(AudioError, match=told):
        recognizer.decode(np.zeros(44100, np.int16))
    with pytest.raises(AudioError, match=told):
        recognizer.listen()


def test_silence_gives_no_utterance(recognizer: Recognizer) -> None:
    silence = [np.zeros(16000, np.int16)] * 3
    assert list(recognizer.utterances(silence, "silence")) == []


def test_the_threshold_decides_what_is_accepted(
    language: LanguageFiles, recordings: list[Recording]
) -> None:
    clip = next(r for r in recordings if r.kind == "near-miss")
    (lenient,) = utterances(Recognizer(language, Recognition(threshold=0)), clip)
    (strict,) = utterances(Recognizer(language, Recognition(threshold=1)), clip)
    assert (lenient.text, lenient.confidence) == (strict.text, strict.confidence)
    assert lenient.accepted
    assert not strict.accepted


def unsure(
    score: float, log_odds: float, folder: Path, threshold: float | None = None
) -> Recognition:
    """Settings by which a command with so much evidence has such odds, where it is quiet."""
    models = load_models()
    intercept = log_odds - models.with_network.weights[SCORE] * score
    mine = replace(models, with_network=replace(models.with_network, intercept=intercept))
    save_models(mine, folder / "unsure.json")
    return Recognition(confidence=str(folder / "unsure.json"), threshold=threshold)


def log_odds(share: float) -> float:
    return math.log(share / (1 - share))


def test_how_many_false_alarms_there_may_be_changes_while_it_listens_and_for_later_commands(
    recognizer: Recognizer, language: LanguageFiles, tmp_path: Path
) -> None:
    blocks = read_blocks(FIXTURES / "near_misses" / "flite_rms__slow_down_a_little.flac")
    sound = np.concatenate([*blocks, pause(1.0)])
    (before,) = recognizer.utterances([sound], "")
    assert before.score
    many, usual = (threshold_for(confidence_model(recognizer), a) for a in (5.0, 0.5))
    between = (log_odds(many) + log_odds(usual)) / 2
    unsure_of_it = Recognizer(language, unsure(before.score, between, tmp_path))
    stream = open_stream(unsure_of_it, "")
    (refused,) = [u for u in stream.feed(sound) if isinstance(u, Utterance)]
    unsure_of_it.set_false_alarm_rate(5.0)
    (accepted,) = [u for u in stream.feed(sound) if isinstance(u, Utterance)]
    assert (refused.accepted, accepted.accepted) == (False, True)
    asked = Recognizer(language, Recognition(false_alarms_per_hour=5.0)).threshold_of("slow down")
    assert unsure_of_it.threshold_of("slow down") == asked
    unsure_of_it.reload()
    assert unsure_of_it.threshold_of("slow down") == asked


def test_words_of_the_trigram_model_that_are_no_command_are_not_accepted(
    language: LanguageFiles, recordings: list[Recording]
) -> None:
    trigrams = Recognizer(language, Recognition(search="lm", threshold=0))
    commands = {r.text for r in recordings if r.kind == "command"}
    others = [r for r in recordings if r.kind == "near-miss"][::3]
    heard = [u for r in others for u in utterances(trigrams, r)]
    assert [u for u in heard if u.text not in commands]
    assert all(u.accepted == (u.text in commands) for u in heard)


def test_what_was_heard_before_reading_failed_is_not_lost(
    recognizer: Recognizer, recordings: list[Recording]
) -> None:
    clip = next(r for r in recordings if r.kind == "command" and r.voice == "flite_slt")

    def failing() -> Iterator[Samples]:
        samples = read_samples(clip.path)
        yield samples[: -len(samples) // 4]  # in the silence after the words
        raise AudioError("cut short")

    heard = []
    with pytest.raises(AudioError, match="cut short"):
        heard.extend(recognizer.utterances(failing(), "clip"))
    (utterance,) = utterances(recognizer, clip)
    first = next(recognizer.utterances(failing(), "clip"))
    assert first.text == utterance.text


@pytest.fixture(scope="module")
def sentence(recordings: list[Recording]) -> Samples:
    """Something that nobody says to a robot, without the silence around it."""
    said = next(r for r in recordings if r.kind == "near-miss" and len(r.text.split()) >= 4)
    (segment,) = segments([said.samples()])
    return segment.samples


def pause(seconds: float) -> Samples:
    return np.random.default_rng(0).normal(0, 8, int(seconds * SAMPLE_RATE)).astype(np.int16)


def heard_as(recognizer: Recognizer, blocks: list[Samples], text: str) -> Utterance:
    """The utterance that is most like a command; other speech is like one too, but less."""
    found = [u for u in recognizer.utterances([np.concatenate(blocks)], "") if u.text == text]
    return max(found, key=lambda u: u.score or -math.inf)


@pytest.fixture(scope="module")
def go_back(recordings: list[Recording]) -> Samples:
    """A command, without the silence around it."""
    said = next(r for r in recordings if (r.voice, r.text) == ("festival_slt", "go back"))
    (segment,) = segments([said.samples()])
    return segment.samples


def score_beside(recognizer: Recognizer, blocks: list[Samples], text: str) -> float:
    """The evidence for a command, among what else is said."""
    score = heard_as(recognizer, blocks, text).score
    assert score is not None
    return score


@pytest.mark.parametrize("around", ["followed", "preceded", "later"])
def test_an_unsure_command_is_no_command_next_to_other_speech(
    around: str,
    recognizer: Recognizer,
    language: LanguageFiles,
    sentence: Samples,
    go_back: Samples,
    tmp_path: Path,
) -> None:
    blocks = {
        "followed": [pause(0.5), go_back, pause(0.25), sentence, pause(1.5)],
        "preceded": [pause(0.5), sentence, pause(0.25), go_back, pause(1.5)],
        "later": [pause(0.5), go_back, pause(1.5), sentence, pause(1.5)],
    }[around]
    score = score_beside(recognizer, blocks, "go back")
    # Sure enough if it is quiet, and not with a twelfth, nor an eighth, of the odds.
    settings = unsure(score, math.log(3), tmp_path, threshold=0.5)
    heard = heard_as(Recognizer(language, settings), blocks, "go back")
    assert heard.accepted == (around == "later")
    if heard.accepted:
        assert heard.t - heard.end > 0.6  # it waited for what follows


def test_less_is_asked_of_a_command_after_quiet_than_after_speech(
    recognizer: Recognizer,
    language: LanguageFiles,
    sentence: Samples,
    go_back: Samples,
    tmp_path: Path,
) -> None:
    after_quiet = [pause(0.5), go_back, pause(0.25), sentence, pause(1.5)]
    after_speech = [pause(0.5), sentence, pause(0.25), go_back, pause(1.5)]
    for blocks, accepted in ((after_quiet, True), (after_speech, False)):
        score = score_beside(recognizer, blocks, "go back")
        # The odds are divided by 8 where it was quiet so far, and by 12 where it was not.
        settings = unsure(score, math.log(10), tmp_path, threshold=0.5)
        demanding = Recognizer(language, settings)
        assert heard_as(demanding, blocks, "go back").accepted == accepted


def test_a_sure_command_does_not_wait(recognizer: Recognizer, session: Recording) -> None:
    for utterance in utterances(recognizer, session):
        assert utterance.accepted
        assert utterance.t - utterance.end < 0.4


def test_festival_and_flite_are_understood_and_a_pause_settles_a_sure_command_early(
    language: LanguageFiles, recordings: list[Recording]
) -> None:
    clips = [r for r in recordings if r.kind == "command" and not r.voice.startswith("espeak")][::2]
    early, late = (Recognizer(language, Recognition(early_decision=s)) for s in (0.06, 1))
    pairs = [(*utterances(early, r), *utterances(late, r)) for r in clips]
    assert share([one.text == r.text for (one, _), r in zip(pairs, clips, strict=True)]) >= 0.97
    assert [one.text for one, _ in pairs] == [other.text for _, other in pairs]
    assert [one.accepted for one, _ in pairs] == [other.accepted for _, other in pairs]
    sooner = [other.t - one.t for one, other in pairs if one.text != "stop"]
    assert min(sooner) >= 0
    assert np.median(sooner) > 0.1
    assert all(one.latency is not None and 0 < one.latency < 1.3 for one, _ in pairs)


def test_what_may_go_on_is_partial_until_it_is_settled(
    recognizer: Recognizer, recordings: list[Recording]
) -> None:
    clips = [r for r in recordings if r.kind == "command" and r.voice == "festival_slt"]
    partials = {}
    for clip in clips:
        *before, last = recognizer.events(read_blocks(clip.path), "")
        assert isinstance(last, Utterance)
        assert (last.text, last.accepted) == (clip.text, True)
        partials[clip.text] = [e.text for e in before if isinstance(e, Partial)]
        assert all(e.t < last.t for e in before)
    assert partials["stop"] == ["stop"]
    assert partials["go forward"] == []


def test_commands_in_quick_succession_are_all_obeyed(
    recognizer: Recognizer, recordings: list[Recording]
) -> None:
    clips = [r for r in recordings if r.kind == "command" and r.voice == "festival_slt"]
    spoken = [s.samples for r in clips for s in segments([r.samples()])]
    blocks = [part for samples in spoken for part in (pause(0.3), samples)]
    heard = list(recognizer.utterances([*blocks, pause(1.0)], ""))
    assert [u.text for u in heard if u.accepted] == [r.text for r in clips]


def test_every_refusal_has_a_reason(recognizer: Recognizer, recordings: list[Recording]) -> None:
    heard = [u for r in recordings if r.kind == "near-miss" for u in utterances(recognizer, r)]
    for utterance in heard:
        assert (utterance.reason is None) == utterance.accepted
        assert (utterance.between is None) == (utterance.reason != "unsure_between")
    assert {u.reason for u in heard} >= {"not_a_command", "part_of_a_command", None}


def test_events_tell_the_evidence_and_what_else_it_may_have_been(
    recognizer: Recognizer, recordings: list[Recording]
) -> None:
    heard = [u for r in recordings if r.kind == "near-miss" for u in utterances(recognizer, r)]
    refused = [u for u in heard if u.score is not None and not u.accepted]
    assert len(refused) > 20
    by_score = sorted((u for u in refused if u.reason != "no_speech"), key=lambda u: u.score or 0)
    assert by_score[0].confidence < by_score[-1].confidence
    go_back = next(r for r in recordings if (r.voice, r.text) == ("festival_slt", "go back"))
    (utterance,) = utterances(recognizer, go_back)
    assert utterance.score
    assert utterance.score > np.percentile([u.score for u in refused if u.score], 80)
    assert utterance.next_best in {*recognizer.commands} - {"go back"}
    assert utterance.above
    assert utterance.above > 25


@pytest.mark.parametrize("missing", [True, False])
def test_without_the_network_pocketsphinx_decides_alone(
    missing: bool,
    language: LanguageFiles,
    recordings: list[Recording],
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    def fail(*_: object) -> None:
        raise UnknownNetworkError("it is of no use here")

    if missing:
        monkeypatch.setattr("voz.recognition.network.score.load_network", fail)
    alone = Recognizer(language, Recognition(use_network=missing))
    assert confidence_model(alone) == load_models().without_network
    said = [r for r in recordings if r.kind == "command" and r.voice == "festival_slt"]
    heard = [utterances(alone, r) for r in said]
    assert [[u.text for u in us] for us in heard] == [[r.text] for r in said]
    assert share([us[0].accepted for us in heard]) > 0.9
    assert all(u.score is None for us in heard for u in us)


def test_what_is_no_speech_is_said_to_be_none(recognizer: Recognizer) -> None:
    time = np.arange(SAMPLE_RATE) / SAMPLE_RATE
    taps = 8000 * np.exp(-time % 0.2 * 60) * np.sin(2 * np.pi * 900 * time)
    sounds = [pause(0.5), taps.astype(np.int16), pause(1.0)]
    heard = list(recognizer.utterances([np.concatenate(sounds)], ""))
    assert not any(u.accepted for u in heard)
    assert {u.reason for u in heard} <= {"no_speech", "too_short"}


def test_commands_are_heard_while_somebody_else_talks_on(
    recognizer: Recognizer, recordings: list[Recording]
) -> None:
    others = [r.samples()[4800:-4800] for r in recordings if r.kind == "near-miss"]
    spoken = [r for r in recordings if r.kind == "command" and r.voice == "flite_slt"]
    talk = np.concatenate(others).astype(float)
    stream = np.resize(talk / np.sqrt(np.mean(talk**2)), (4 * len(spoken) + 6) * SAMPLE_RATE)
    stream *= 2000 / 10 ** (15 / 20)  # 15 dB below the commands
    places = []
    for number, recording in enumerate(spoken):
        clip, at = recording.samples().astype(float), (5 + 4 * number) * SAMPLE_RATE
        loud = clip[np.abs(clip) > 300]
        stream[at : at + len(clip)] += clip * 2000 / np.sqrt(np.mean(loud**2))
        places.append((recording.text, at / SAMPLE_RATE, (at + len(clip)) / SAMPLE_RATE))
    sound = np.clip(stream, -32768, 32767).astype(np.int16)
    obeyed = [u for u in recognizer.utterances([sound], "") if u.accepted]
    heard = [
        [u.text for u in obeyed if u.end > begin and u.start < end] == [text]
        for text, begin, end in places
    ]
    assert share(heard) >= 0.6
    assert len(obeyed) <= len(places)


def test_a_whispered_command_that_the_network_knows_is_speech(
    recognizer: Recognizer, monkeypatch: pytest.MonkeyPatch
) -> None:
    """The voice detector alone doubts most of them."""
    monkeypatch.setitem(VOICES, "whisper", Voice.espeak("en-us+whisper"))
    random = np.random.default_rng(0)
    whispered = {t: with_floor(phrase("whisper", t), random) for t in recognizer.commands}

    def accepted() -> int:
        heard = {text: recognizer.decode(sound, SAMPLE_RATE) for text, sound in whispered.items()}
        return sum((u.text, u.accepted) == (text, True) for text, us in heard.items() for u in us)

    with_less_voice = accepted()
    monkeypatch.setattr("voz.recognition.confidence.SOFT_SPEECH_VOICE", 1.1)
    assert with_less_voice > accepted() + 1


BACKGROUND = """
import sys, threading
import voz

wanted, heard, enough = int(sys.argv[1]), [], threading.Event()

def take(utterance):
    print(utterance, flush=True)
    heard.append(utterance)
    if len(heard) == wanted:
        enough.set()
    if sys.argv[2] == "exit":
        enough.set()
        sys.exit(3)
    if sys.argv[2] == "fail":
        enough.set()
        raise ValueError("not this one")

stop = voz.load().listen_in_background(take)
print("listening", flush=True)
enough.wait(60)
try:
    stop()
except (ValueError, SystemExit) as error:
    print("raised:", error)
print("threads:", threading.active_count())
"""


def test_a_file_is_decoded_by_its_name(recognizer: Recognizer, session: Recording) -> None:
    by_name = recognizer.decode(str(session.path))
    assert by_name == recognizer.decode(session.path)
    assert [str(heard) for heard in by_name if heard] == session.commands
    assert {heard.source for heard in by_name} == {str(session.path)}


def test_a_file_has_its_own_rate(recognizer: Recognizer, session: Recording) -> None:
    with pytest.raises(AudioError, match="a file has its own rate"):
        recognizer.decode(session.path, rate=16000)
    with pytest.raises(AudioError, match="there is no such file"):
        recognizer.decode("no_such_file.wav")


def in_blocks(samples: Samples) -> Iterator[Samples]:
    yield from np.array_split(samples, len(samples) // 1600)


async def in_blocks_async(samples: Samples) -> AsyncIterator[Samples]:
    for block in in_blocks(samples):
        await asyncio.sleep(0)
        yield block


@pytest.mark.parametrize("blocks", [in_blocks, in_blocks_async])
def test_a_stream_is_recognized_while_the_event_loop_goes_on(
    blocks: object, recognizer: Recognizer, session: Recording
) -> None:
    turns = 0

    async def listen() -> list[Utterance]:
        async def count() -> None:
            nonlocal turns
            while True:
                turns += 1
                await asyncio.sleep(0)

        counting = asyncio.create_task(count())
        stream = recognizer.astream(blocks(session.samples()), SAMPLE_RATE)  # type: ignore[operator]
        heard = [utterance async for utterance in stream]
        counting.cancel()
        return heard

    assert [str(heard) for heard in asyncio.run(listen()) if heard] == session.commands
    assert turns > len(session.commands)


def test_a_stream_without_rate_is_refused_at_once(recognizer: Recognizer) -> None:
    with pytest.raises(AudioError, match="rate"):
        recognizer.astream([np.zeros(1600, np.int16)])


@pytest.mark.slow
@pytest.mark.parametrize("how", ["well", "fail", "exit"])
def test_a_microphone_is_listened_to_in_the_background(how: str, pulse: dict[str, str]) -> None:
    command = [sys.executable, "-c", BACKGROUND, "2", how]
    with subprocess.Popen(command, env=pulse, stdout=subprocess.PIPE, text=True) as process:
        assert process.stdout is not None
        assert process.stdout.readline() == "listening\n"
        for _ in range(2 if how == "well" else 1):
            subprocess.run(["paplay", "--device=mic", str(GO_BACK)], env=pulse, check=True)
        output, _ = process.communicate(timeout=60)
    raised = {"fail": "raised: not this one", "exit": "raised: 3"}
    heard = ["go back", "go back"] if how == "well" else ["go back", raised[how]]
    assert output.splitlines() == [*heard, "threads: 1"]
