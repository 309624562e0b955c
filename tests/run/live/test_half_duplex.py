"""A robot whose microphone hears its own loudspeaker, both of a real sound server."""

from __future__ import annotations

import subprocess
import time
from collections.abc import Iterator
from pathlib import Path
from typing import NamedTuple

import numpy as np
import numpy.typing as npt
import pytest
from driving import STARTED
from live_robot import live_robot, speak
from loudspeaker import play_into
from pulseaudio import pactl
from recordings import FIXTURES

from voz.api.recognizer import Recognizer
from voz.audio import SAMPLE_RATE, Samples
from voz.audio.loudspeaker import Mixer
from voz.audio.microphone import open_microphone
from voz.audio.playback import PLAYBACK_RATE
from voz.audio.sound_files import read_sound
from voz.events import Utterance
from voz.hearing.half_duplex import MAX_RECENT_SECONDS, HalfDuplex
from voz.speech.synthesis import cached_speech

pytestmark = [pytest.mark.slow, pytest.mark.realtime]

# A room delays by the same time always. With less latency a busy machine's loopback runs out of
# sound; then, as without adjust_time=0, it changes its rate, and no echo canceller can follow.
LOOPBACK = (
    "load-module module-loopback source=speaker.monitor sink=mic latency_msec=200 adjust_time=0"
)

STORY = (
    "this is a long story of a small machine. it has two wheels, a camera and a good friend. every "
    "morning it takes a cup of tea to the window, and every evening it finds its way home again"
)


@pytest.fixture
def one_room(
    own_pulse: tuple[dict[str, str], subprocess.Popen[bytes]],
) -> dict[str, str]:
    """What goes to the loudspeaker comes into the microphone too."""
    environment, _ = own_pulse
    pactl(environment, LOOPBACK)
    return environment


def recording_of(text: str) -> Path:
    return FIXTURES / "commands" / f"festival_slt__{text.replace(' ', '_')}.flac"


class Block(NamedTuple):
    """A block of the microphone, and what was known of the loudspeaker when it arrived."""

    samples: Samples
    arrived: float
    busy_until: float
    replies: str | None
    played: npt.NDArray[np.float32]
    end: float


class Played:
    """The loudspeaker as it was known at each block."""

    block: Block

    def busy_until(self) -> float:
        return self.block.busy_until

    def replies(self) -> str | None:
        return self.block.replies

    def recent(self, seconds: float) -> tuple[npt.NDArray[np.float32], float]:
        return self.block.played[-round(seconds * SAMPLE_RATE) :], self.block.end


def listened(mixer: Mixer, environment: dict[str, str], *said: str) -> Iterator[Block]:
    """What arrives while commands are said into a story, until it ends."""
    sound = read_sound(cached_speech(STORY, "kal_diphone"), PLAYBACK_RATE)[: 7 * PLAYBACK_RATE]
    story = mixer.play(sound, text=STORY)
    began, saying = time.monotonic(), []
    with open_microphone() as microphone:
        for samples in microphone:
            yield Block(
                samples, microphone.arrived, mixer.busy_until(), mixer.replies(),
                *mixer.recent(MAX_RECENT_SECONDS),
            )  # fmt: skip
            if len(saying) < len(said) and time.monotonic() > began + 2 + 3 * len(saying):
                path = recording_of(said[len(saying)])
                command = ["paplay", "--device=mic", "--latency-msec=2000", str(path)]
                saying.append(subprocess.Popen(command, env=environment))
            if story.over and microphone.arrived > mixer.busy_until() + 1:
                break
    assert [process.wait() for process in saying] == [0] * len(said)


def test_of_a_story_nothing_counts_but_stop_that_is_said_into_it_does(
    one_room: dict[str, str], recognizer: Recognizer, monkeypatch: pytest.MonkeyPatch
) -> None:
    play_into(one_room, monkeypatch)
    mixer, played = Mixer(lambda text: None), Played()
    mixer.barge_in = True
    try:
        blocks = list(listened(mixer, one_room, "go forward", "stop"))
    finally:
        mixer.close()
    # It is understood only now: a slow machine may need longer for it than it takes to be said.
    duplex, obeyed = HalfDuplex(recognizer, played, ("stop",)), []
    for block in blocks:
        played.block = block
        for event in duplex.feed(block.samples, block.arrived):
            if isinstance(event, Utterance) and event.accepted and not event.ignored:
                obeyed.append(event.text)
    # The echo of a busy machine has gaps, and cannot be removed there; then only `stop` counts.
    # It is settled at once, other commands at a pause: a stop overtakes what was said before it.
    assert {"stop"} <= set(obeyed) <= {"stop", "go forward"}


@pytest.mark.parametrize("headset", [False, True])
def test_only_with_a_headset_is_the_reply_there_to_be_heard(
    headset: bool, one_room: dict[str, str]
) -> None:
    options = ["--no-half-duplex"] if headset else []
    with live_robot(one_room, *options, sound=True) as robot:
        speak(one_room, recording_of("start speech"))
        robot.wait_for(lambda event: event["type"] == "reply")
        if headset:
            robot.wait_for(lambda e: e["type"] == "utterance" and e["text"] != "start speech")
        else:
            time.sleep(4)  # it takes two to say
        assert [event["text"] for event in robot.of("reply")] == [STARTED]
        assert headset or [e["text"] for e in robot.of("utterance")] == ["start speech"]
