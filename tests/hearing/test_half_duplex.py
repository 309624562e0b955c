"""While the loudspeaker sounds, only what must not be missed is heard."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt
import pytest
from recordings import Recording

from voz.api.recognizer import Recognizer
from voz.audio import SAMPLE_RATE, Samples
from voz.events import Utterance
from voz.hearing.half_duplex import REVERBERATION_SECONDS, HalfDuplex

BLOCK = 480


class Loudspeaker:
    """One whose sound, at 16 kHz, is known from the beginning."""

    def __init__(self, sound: npt.NDArray[np.float64], text: str | None = None) -> None:
        self.sound = sound
        self.text = text
        self.now = 0.0

    def replies(self) -> str | None:
        """The words of the sound, if commands count that have none of them."""
        return self.text

    def busy_until(self) -> float:
        """The end of the sound."""
        return len(np.trim_zeros(self.sound, "b")) / SAMPLE_RATE

    def recent(self, seconds: float) -> tuple[npt.NDArray[np.float32], float]:
        """The sound up to now."""
        length = round(seconds * SAMPLE_RATE)
        at = round(self.now * SAMPLE_RATE)
        padded = np.pad(self.sound, (length, len(self.sound) + at))
        return padded[at : at + length].astype(np.float32), self.now


def heard(
    recognizer: Recognizer,
    samples: Samples,
    loudspeaker: Loudspeaker | None,
    ignored: list[str] | None = None,
) -> list[tuple[float, str]]:
    """What counts, and when; what is only told goes into a list of its own."""
    duplex = HalfDuplex(recognizer, loudspeaker, ("stop",))
    found = []
    ignored = [] if ignored is None else ignored
    for end in range(BLOCK, len(samples), BLOCK):
        if loudspeaker:
            loudspeaker.now = end / SAMPLE_RATE
        for event in duplex.feed(samples[end - BLOCK : end], end / SAMPLE_RATE):
            if not isinstance(event, Utterance) or (event.accepted and not event.ignored):
                found.append((event.t, event.text))
            elif event.accepted:
                ignored.append(event.text)
    return found


def spoken(recordings: list[Recording], *texts: str) -> Samples:
    """Commands with a second of pause before and after each."""
    clips = [
        next(r for r in recordings if r.text == text and r.voice == "flite_slt") for text in texts
    ]
    parts = [part for clip in clips for part in (np.zeros(SAMPLE_RATE), clip.samples())]
    sound = np.concatenate([*parts, np.zeros(SAMPLE_RATE)])
    return (sound + np.random.default_rng(0).normal(0, 8, len(sound))).astype(np.int16)


def test_with_a_headset_all_is_heard(recognizer: Recognizer, recordings: list[Recording]) -> None:
    samples = spoken(recordings, "start speech", "go forward", "stop")
    texts = [text for _, text in heard(recognizer, samples, None)]
    assert list(dict.fromkeys(texts)) == ["start speech", "go forward", "stop"]


def test_after_the_reply_all_is_heard_again(
    recognizer: Recognizer, recordings: list[Recording], session: Recording
) -> None:
    samples = spoken(recordings, "go forward", "go back", "turn left")
    reply = np.zeros(len(samples))
    quiet = session.samples()[SAMPLE_RATE : 4 * SAMPLE_RATE] / 32768 * 1e-3
    reply[: len(quiet)] = quiet  # too quiet to be heard by the microphone: only known of
    loudspeaker = Loudspeaker(reply)
    ignored: list[str] = []
    found = heard(recognizer, samples, loudspeaker, ignored)
    assert ignored == ["go forward"]
    assert [text for _, text in found][-1] == "turn left"
    assert "go forward" not in [text for _, text in found]
    assert all(t > loudspeaker.busy_until() + REVERBERATION_SECONDS for t, _ in found)


def test_stop_is_heard_while_the_robot_speaks(
    recognizer: Recognizer, recordings: list[Recording], session: Recording
) -> None:
    samples = spoken(recordings, "go forward", "stop")
    reply = np.resize(session.samples() / 32768, len(samples))
    mixed = (samples + 0.05 * 32768 * reply).astype(np.int16)
    found = heard(recognizer, mixed, Loudspeaker(reply))
    assert {text for _, text in found} == {"stop"}
    said_at = len(spoken(recordings, "go forward")) / SAMPLE_RATE
    assert said_at < found[0][0] < said_at + 2.5


def test_a_command_said_into_a_reply_that_is_known_is_heard_at_once(
    recognizer: Recognizer, recordings: list[Recording]
) -> None:
    samples = spoken(recordings, "go forward", "turn left")
    reply = np.roll(spoken(recordings, "fold arm", "point beer") / 32768, 6000)
    reply = np.resize(reply, len(samples))
    mixed = (samples + 0.3 * 32768 * reply).astype(np.int16)
    ignored: list[str] = []
    found = heard(recognizer, mixed, Loudspeaker(reply, "turn around"), ignored)
    assert [text for _, text in found] == ["go forward"]
    assert ignored == ["turn left"]  # a word of it is in the reply


def test_what_is_being_said_when_a_reply_ends_is_heard_whole(
    recognizer: Recognizer, recordings: list[Recording]
) -> None:
    samples = spoken(recordings, "go forward")
    reply = np.zeros(len(samples))
    reply[: int(1.2 * SAMPLE_RATE)] = 1e-4  # the command has just begun
    (found,) = heard(recognizer, samples, Loudspeaker(reply, "I am listening"))
    assert found[1] == "go forward"


def test_a_known_reply_that_says_commands_moves_nothing_even_if_it_comes_too_late_to_be_removed(
    recognizer: Recognizer, recordings: list[Recording]
) -> None:
    said = spoken(recordings, "go forward", "turn left")
    assert heard(recognizer, said, None)
    for late in (0.1, 0.9, 1.5):
        reply = np.concatenate([said, np.zeros(4 * SAMPLE_RATE)]) / 32768
        echo = np.roll(reply, round(late * SAMPLE_RATE))
        loudspeaker = Loudspeaker(reply, "go forward, turn left")
        assert heard(recognizer, (echo * 32768).astype(np.int16), loudspeaker) == []


def test_a_reply_that_sounds_like_commands_moves_nothing_whatever_its_words_are(
    recognizer: Recognizer, recordings: list[Recording]
) -> None:
    said = spoken(recordings, "go forward", "turn left")
    reply = np.concatenate([said, np.zeros(4 * SAMPLE_RATE)]) / 32768
    echo = np.roll(reply, SAMPLE_RATE * 3 // 2)  # too late to be removed
    loudspeaker = Loudspeaker(reply, "4 words, tern lefft")
    ignored: list[str] = []
    assert heard(recognizer, (echo * 32768).astype(np.int16), loudspeaker, ignored) == []
    assert "go forward" in ignored


@pytest.mark.parametrize("late", [0.9, 1.4, 2.0])
def test_a_late_loudspeaker_moves_nothing_by_the_robot_s_words(
    late: float, recognizer: Recognizer, recordings: list[Recording]
) -> None:
    said = spoken(recordings, "go forward")
    sound = np.where(np.abs(said) > 100, said, 0) / 32768  # the noise of the room is not played
    reply = np.concatenate([sound, np.zeros(4 * SAMPLE_RATE)])
    room = np.convolve(np.roll(reply, round(late * SAMPLE_RATE)), [0.5, 0, 0, 0.3, -0.1], "same")
    room += np.random.default_rng(0).normal(0, 8 / 32768, len(room))
    ignored: list[str] = []
    found = heard(recognizer, (room * 32768).astype(np.int16), Loudspeaker(reply), ignored)
    assert found == []
    assert ignored == ["go forward"]


def test_what_somebody_else_says_after_a_reply_counts_and_the_same_words_a_little_later(
    recognizer: Recognizer, recordings: list[Recording]
) -> None:
    reply = spoken(recordings, "go forward")[: -SAMPLE_RATE // 2]
    pause = np.zeros(2 * SAMPLE_RATE, np.int16)
    said = np.concatenate(
        [spoken(recordings, "go back", "turn left"), pause, spoken(recordings, "go forward")]
    )
    loudspeaker = Loudspeaker(np.concatenate([reply, 0 * said]) / 32768)
    ignored: list[str] = []
    found = heard(recognizer, np.concatenate([0 * reply, said]), loudspeaker, ignored)
    assert list(dict.fromkeys(t for _, t in found)) == ["go back", "turn left", "go forward"]
    assert ignored == []


def test_a_stop_in_the_reply_is_none(recognizer: Recognizer, recordings: list[Recording]) -> None:
    reply = np.tile(spoken(recordings, "stop")[SAMPLE_RATE // 2 : -SAMPLE_RATE // 2], 3) / 32768
    driven = 2 * reply / np.abs(reply).max()
    echo = 6000 * np.tanh(driven + 0.3 * driven**2)
    assert heard(recognizer, echo.astype(np.int16), None)
    assert heard(recognizer, echo.astype(np.int16), Loudspeaker(reply)) == []


def test_the_robot_does_not_obey_itself(recognizer: Recognizer, session: Recording) -> None:
    said = session.samples()[: 10 * SAMPLE_RATE]
    mixed = np.concatenate([said, np.zeros(SAMPLE_RATE, np.int16)])
    assert heard(recognizer, mixed, None)  # it says commands
    assert heard(recognizer, mixed, Loudspeaker(mixed / 32768)) == []
