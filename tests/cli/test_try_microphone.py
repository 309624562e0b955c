"""What `voz devices --test` writes of a recording."""

from __future__ import annotations

import pytest

from voz.audio.recording_level import RecordingLevel
from voz.cli.audio_commands import report


@pytest.mark.parametrize(
    ("background", "said"),
    [(-70.0, "about 97 of 100 commands are obeyed"), (-23.0, "will have to be said again")],
)
def test_it_says_what_the_background_means_for_commands(background: float, said: str) -> None:
    *_, figure, meaning = report(RecordingLevel(False, -3.0, -20.0, background, 0.0))
    assert figure.startswith("signal to noise")
    assert said in meaning


def test_where_nobody_spoke_there_is_nothing_to_say_about_the_background() -> None:
    assert report(RecordingLevel(False, -3.0, None, -60.0, 0.0))[-1] == "signal to noise     -"
