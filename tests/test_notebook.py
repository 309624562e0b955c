"""How an utterance looks in a notebook."""

from __future__ import annotations

import base64
import io
from html.parser import HTMLParser
from pathlib import Path

import numpy as np
import pytest
import soundfile
from msgspec.structs import replace
from recordings import Recording

import voz
from voz.api.recognizer import Recognizer
from voz.audio import SAMPLE_RATE, Samples
from voz.notebook import MARGIN, MAX_KEPT_SOUNDS, MAX_PLAYED_SECONDS, keep_sounds

HEARD = voz.Utterance(
    5.6, "go forward", 0.98, True, 4.7, 5.6, "microphone", above=31.4, latency=0.2, score=24.9,
    next_best="go back",
)  # fmt: skip


class Page(HTMLParser):
    """What a browser shows: texts, and the sound of players."""

    def __init__(self, heard: voz.Utterance) -> None:
        super().__init__()
        self.tags: list[str] = []
        self.texts: list[str] = []
        self.sounds: list[Samples] = []
        self.feed(heard._repr_html_())
        self.close()
        self.text = " ".join(self.texts)

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        self.tags.append(tag)
        if tag == "audio":
            kind, _, data = (dict(attrs)["src"] or "").partition(";base64,")
            assert kind == "data:audio/wav"
            sound, rate = soundfile.read(io.BytesIO(base64.b64decode(data)), dtype="int16")
            assert rate == SAMPLE_RATE
            self.sounds.append(sound)

    def handle_data(self, data: str) -> None:
        self.texts.append(data)


def stretch(samples: Samples, heard: voz.Utterance) -> Samples:
    start, end = max(0.0, heard.start - MARGIN), heard.end + MARGIN
    return samples[round(start * SAMPLE_RATE) : round(end * SAMPLE_RATE)]


def test_it_says_what_was_heard_and_both_opinions() -> None:
    page = Page(HEARD)
    for part in ("“go forward”", "accepted", "98% sure", "also have been “go back”", "24.9"):
        assert part in page.text
    assert page.sounds == []  # of a microphone none is kept
    refused = replace(HEARD, accepted=False, command=None, reason="part_of_a_command", score=-4.2)
    assert "not accepted: part of a command" in Page(refused).text
    assert "rather hears something else" in Page(refused).text
    unsure = replace(refused, reason="unsure_between", between=("go back", "go forward"))
    assert 'unsure between "go back" and "go forward"' in Page(unsure).text
    assert "It was not asked" in Page(replace(HEARD, score=None)).text
    assert "It was typed" in Page(replace(HEARD, above=None, latency=None, source="text")).text


def test_no_text_is_taken_for_markup() -> None:
    odd = '<script>alert("&amp;")</script>'
    page = Page(replace(HEARD, text=odd, next_best=odd, accepted=False, between=(odd, odd)))
    assert page.tags == Page(HEARD).tags
    assert page.text.count(odd) == 4


def test_the_sound_in_an_array_is_played(recognizer: Recognizer, session: Recording) -> None:
    samples = session.samples()
    heard = recognizer.decode(samples, SAMPLE_RATE)
    assert len(heard) == len(session.commands)
    for each in heard:
        (sound,) = Page(each).sounds
        np.testing.assert_array_equal(sound, stretch(samples, each))


def test_the_sound_in_a_file_is_played_while_it_is_there(
    recognizer: Recognizer, recordings: list[Recording], tmp_path: Path
) -> None:
    clip = next(each for each in recordings if each.kind == "command")
    path = tmp_path / "take.wav"
    soundfile.write(path, clip.samples(), SAMPLE_RATE)
    (heard,) = recognizer.decode(path)
    (sound,) = Page(heard).sounds
    np.testing.assert_array_equal(sound, stretch(clip.samples(), heard))
    path.write_bytes(b"something else")
    assert Page(heard).sounds == []
    path.unlink()
    assert Page(heard).sounds == []


def test_little_sound_is_kept_and_a_long_one_is_cut() -> None:
    samples = np.ones(30 * SAMPLE_RATE, np.int16)
    many = [replace(HEARD, start=n, end=n + 25, source="array") for n in range(MAX_KEPT_SOUNDS + 1)]
    keep_sounds(many, samples)
    assert Page(many[0]).sounds == []
    (sound,) = Page(many[1]).sounds
    assert len(sound) == MAX_PLAYED_SECONDS * SAMPLE_RATE


@pytest.mark.parametrize("heard", [HEARD, replace(HEARD, text="two\nlines")])
def test_its_repr_is_one_line(heard: voz.Utterance) -> None:
    assert "\n" not in repr(heard)
    assert str(heard) == heard.text
