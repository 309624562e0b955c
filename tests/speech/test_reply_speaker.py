"""Replies: one after the other, at once if they were prepared, and never in the way."""

from __future__ import annotations

import threading
import time
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
from hanging import wait_for_end
from loudspeaker import Recorder, at_16_khz, place_of
from programs import PATIENCE, wait_until

from voz.audio.playback import PLAYBACK_RATE
from voz.audio.sound_files import read_sound
from voz.config import default_commands
from voz.speech import synthesis
from voz.speech.reply_speaker import MAX_QUEUED_REPLIES, ReplySpeaker
from voz.speech.synthesis import cached_speech, is_cached

REPLIES = default_commands().replies
KAL = "kal_diphone"


class Gate:
    """A client that says nothing until it is opened, and remembers what it said then."""

    def __init__(self, monkeypatch: pytest.MonkeyPatch) -> None:
        self.opened = threading.Event()
        self.closed = threading.Event()
        self.said: list[str] = []
        monkeypatch.setattr(
            "voz.speech.sound_client.SoundClient.say", lambda _, text: self.say(text)
        )
        monkeypatch.setattr(
            "voz.speech.sound_client.SoundClient.close", lambda _: self.closed.set()
        )
        monkeypatch.setattr("voz.audio.loudspeaker.Mixer.prepare", lambda _: None)
        monkeypatch.setattr("voz.speech.reply_speaker.is_cached", lambda text, voice: True)

    def say(self, text: str) -> None:
        while not self.opened.wait(0.01) and not self.closed.is_set():
            pass
        if not self.closed.is_set():
            self.said.append(text)


@pytest.fixture
def gate(monkeypatch: pytest.MonkeyPatch) -> Gate:
    return Gate(monkeypatch)


def place_in(samples: np.ndarray, text: str) -> float:
    """Where in what was heard a text is, s; it must be there."""
    wave = at_16_khz(read_sound(cached_speech(text, KAL), PLAYBACK_RATE))
    loud = np.flatnonzero(np.abs(wave) > 0.02)
    shift, alike = place_of(wave[loud[0] : loud[-1]], samples)
    assert alike > 0.95
    return shift / 16_000


@pytest.mark.slow
def test_replies_are_heard_one_after_the_other_before_it_closes(loudspeaker: Recorder) -> None:
    one, _ = (cached_speech(text, KAL) for text in ("one", "twelve"))  # so that neither is late
    warned: list[str] = []
    with ReplySpeaker(KAL, warn=warned.append) as speaker:
        speaker.say("one")
        speaker.say("twelve")
    samples, _ = speaker.mixer.recent(5)
    assert place_in(samples, "twelve") - place_in(samples, "one") > 0.3
    assert np.abs(samples).max() < 1.05 * np.abs(read_sound(one, PLAYBACK_RATE)).max() + 0.5
    assert warned == []


def test_say_does_not_wait_for_the_sound(gate: Gate) -> None:
    speaker = ReplySpeaker(KAL)
    speaker.say("one")
    assert gate.said == []
    gate.opened.set()
    speaker.close()
    assert gate.said == ["one"]


def test_what_is_queued_is_forgotten_when_it_is_interrupted(gate: Gate) -> None:
    speaker = ReplySpeaker(KAL)
    for text in ("one", "two", "three"):
        speaker.say(text)
    speaker.interrupt()
    speaker.say("four")
    gate.opened.set()
    speaker.close()
    assert gate.said[-1] == "four"
    assert gate.said[:-1] in ([], ["one"])  # which may have begun


def test_replies_that_are_prepared_are_rendered_before_they_are_said() -> None:
    warned: list[str] = []
    speaker = ReplySpeaker(KAL, REPLIES, warned.append)
    wait_until(lambda: all(is_cached(reply, KAL) for reply in REPLIES))
    speaker.close()
    assert warned == []


def test_closing_does_not_wait_for_replies_that_nobody_needs_any_more(
    slow_festival: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(synthesis, "FESTIVAL_TIMEOUT", 60.0)
    warned: list[str] = []
    speaker = ReplySpeaker(KAL, REPLIES, warned.append)
    deadline = time.monotonic() + PATIENCE
    wait_until(slow_festival.exists)
    speaker.close(timeout=PATIENCE)
    assert time.monotonic() < deadline
    wait_for_end(slow_festival)
    assert warned == []


@pytest.mark.usefixtures("loudspeaker")
def test_a_festival_that_hangs_keeps_back_no_reply_that_is_ready(
    monkeypatch: pytest.MonkeyPatch, request: pytest.FixtureRequest
) -> None:
    cached_speech("known", KAL)
    child = request.getfixturevalue("slow_festival")
    monkeypatch.setattr(synthesis, "FESTIVAL_TIMEOUT", 60.0)
    speaker = ReplySpeaker(KAL)
    speaker.say("not known")
    speaker.say("known")
    wait_until(lambda: child.exists() and speaker.mixer.busy_until() >= time.monotonic())
    wait_until(lambda: speaker.mixer.busy_until() < time.monotonic())
    speaker.close(timeout=0)
    place_in(speaker.mixer.recent(5)[0], "known")
    wait_for_end(child)


def test_a_text_without_sound_is_told(gate: Gate, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("voz.speech.reply_speaker.is_cached", is_cached)
    warned: list[str] = []
    with ReplySpeaker(KAL, warn=warned.append) as speaker:
        speaker.say("...")
    (warning,) = warned
    assert "nothing to speak" in warning


def test_the_oldest_replies_are_left_out_when_too_many_wait(gate: Gate) -> None:
    texts = [f"number {n}" for n in range(MAX_QUEUED_REPLIES + 4)]
    with ReplySpeaker(KAL) as speaker:
        for text in texts:
            speaker.say(text)
        gate.opened.set()
    assert gate.said[-MAX_QUEUED_REPLIES:] == texts[-MAX_QUEUED_REPLIES:]
    assert len(gate.said) <= MAX_QUEUED_REPLIES + 1


def test_closing_leaves_out_what_is_not_said_in_time(
    gate: Gate, begun: Callable[[], list[threading.Thread]]
) -> None:
    speaker = ReplySpeaker(KAL)
    speaker.say("one")
    speaker.say("two")
    speaker.close(timeout=0.1)
    assert begun() == []
    assert gate.said == []


def test_after_closing_nothing_is_said(gate: Gate) -> None:
    gate.opened.set()
    warned: list[str] = []
    speaker = ReplySpeaker(KAL, warn=warned.append)
    speaker.close()
    speaker.close()
    speaker.say("one")
    assert gate.said == warned == []
