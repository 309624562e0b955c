from __future__ import annotations

import os
import subprocess
import sys
import threading
import time
from pathlib import Path

import pytest

from voz.errors import AudioError
from voz.speech import speaker as module
from voz.speech.festival import cached
from voz.speech.speaker import LONGEST_QUEUE, Speaker

REPLY = "bep bep. I am listening you"
KAL = "kal_diphone"


@pytest.fixture
def heard(monkeypatch: pytest.MonkeyPatch) -> list[Path]:
    """A loudspeaker that only remembers what it was given."""
    paths: list[Path] = []
    monkeypatch.setattr(module, "play", lambda path, stopped: paths.append(path))
    return paths


@pytest.fixture
def gate(monkeypatch: pytest.MonkeyPatch, heard: list[Path]) -> threading.Event:
    """A loudspeaker that is busy until the event is set; every text is its own path."""
    event = threading.Event()

    def play(path: Path, stopped: threading.Event) -> None:
        while not event.wait(0.01) and not stopped.is_set():
            pass
        if not stopped.is_set():
            heard.append(path)

    monkeypatch.setattr(module, "cached", lambda text, voice: Path(text))
    monkeypatch.setattr(module, "play", play)
    return event


def test_replies_are_said_in_order_before_it_closes(heard: list[Path]) -> None:
    with Speaker(KAL) as speaker:
        speaker.say("one")
        speaker.say("two")
    assert heard == [cached("one", KAL), cached("two", KAL)]
    assert speaker.drain_warnings() == []


def test_say_does_not_wait_for_the_sound(heard: list[Path]) -> None:
    start = time.monotonic()
    with Speaker(KAL) as speaker:
        speaker.say(REPLY)
        said = time.monotonic() - start
    assert heard
    assert said < (time.monotonic() - start) / 10


def test_missing_festival_is_told_once_and_the_rest_goes_on(
    monkeypatch: pytest.MonkeyPatch, heard: list[Path]
) -> None:
    cached("known", KAL)
    monkeypatch.setenv("PATH", "")
    with Speaker(KAL) as speaker:
        for text in ("one", "two", "known"):
            speaker.say(text)
    (warning,) = speaker.drain_warnings()
    assert warning.startswith("festival is not installed")
    assert heard == [cached("known", KAL)]
    assert speaker.drain_warnings() == []


def test_a_silent_loudspeaker_is_told_once(monkeypatch: pytest.MonkeyPatch) -> None:
    def play(path: Path, stopped: threading.Event) -> None:
        raise AudioError("there is no loudspeaker")

    monkeypatch.setattr(module, "play", play)
    with Speaker(KAL) as speaker:
        speaker.say("one")
        speaker.say("two")
    assert speaker.drain_warnings() == ["there is no loudspeaker"]


def test_a_computer_without_sound_gives_one_warning(tmp_path: Path) -> None:
    alsa = tmp_path / "alsa.conf"
    alsa.write_text("pcm.default { type hw card 99 }")
    script = (
        "from voz.speech.speaker import Speaker\n"
        "with Speaker('kal_diphone') as speaker:\n"
        "    speaker.say('one'); speaker.say('two')\n"
        "print(*speaker.drain_warnings(), sep='\\n')"
    )
    done = subprocess.run(
        [sys.executable, "-c", script],
        env=os.environ | {"ALSA_CONFIG_PATH": str(alsa)},
        capture_output=True,
        text=True,
        check=True,
    )
    assert done.stdout == "there is no loudspeaker; connect one and start again\n"
    assert done.stderr == ""


def test_the_oldest_replies_are_left_out_when_too_many_wait(
    gate: threading.Event, heard: list[Path]
) -> None:
    texts = [f"number {n}" for n in range(LONGEST_QUEUE + 4)]
    with Speaker(KAL) as speaker:
        for text in texts:
            speaker.say(text)
        gate.set()
    assert heard[-LONGEST_QUEUE:] == [Path(text) for text in texts[-LONGEST_QUEUE:]]
    assert len(heard) <= LONGEST_QUEUE + 1


@pytest.mark.usefixtures("gate")
def test_closing_leaves_out_what_is_not_said_in_time(heard: list[Path]) -> None:
    speaker = Speaker(KAL)
    speaker.say("one")
    speaker.say("two")
    speaker.close(timeout=0.1)
    assert not any(thread.name == "voz-speaker" for thread in threading.enumerate())
    assert heard == []


def test_after_closing_nothing_is_said(heard: list[Path]) -> None:
    speaker = Speaker(KAL)
    speaker.close()
    speaker.close()
    speaker.say(REPLY)
    assert heard == []
    assert speaker.drain_warnings() == []
