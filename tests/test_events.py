"""The names and the order of what is written are what other programs read."""

from __future__ import annotations

import pytest

from voz.events import Attention, Event, Notice, Reply, SelectedObject, Twist, Utterance, to_json


@pytest.mark.parametrize(
    ("event", "line"),
    [
        (
            Utterance(1.5, "go back", 0.93, True, 0.2, 1.1, "a.wav"),
            '{"type":"utterance","t":1.5,"text":"go back","confidence":0.93,"accepted":true,'
            '"start":0.2,"end":1.1,"source":"a.wav"}',
        ),
        (Twist(0.1, -0.15, 0.0), '{"type":"cmd_vel","t":0.1,"linear":-0.15,"angular":0.0}'),
        (SelectedObject(0.1, 100), '{"type":"selected_object","t":0.1,"value":100}'),
        (Attention(0.1, awake=True), '{"type":"attention","t":0.1,"awake":true}'),
        (Reply(0.1, "bep bep"), '{"type":"reply","t":0.1,"text":"bep bep"}'),
        (Notice(0.1, "two\nlines"), '{"type":"warning","t":0.1,"text":"two\\nlines"}'),
        (
            Notice(0.1, "listening again", good=True),
            '{"type":"warning","t":0.1,"text":"listening again","good":true}',
        ),
        # The name of a file need be no text.
        (Notice(0.1, "no \udcff.wav"), '{"type":"warning","t":0.1,"text":"no ?.wav"}'),
    ],
)
def test_an_event_is_one_line_of_json(event: Event, line: str) -> None:
    assert to_json(event) == line


def test_an_utterance_is_its_text_and_true_if_it_is_accepted() -> None:
    accepted = Utterance(1.5, "go back", 0.93, True, 0.2, 1.1, "a.wav")
    refused = Utterance(1.5, "go back", 0.31, False, 0.2, 1.1, "a.wav", reason="not_a_command")
    assert (str(accepted), bool(accepted)) == ("go back", True)
    assert (str(refused), bool(refused)) == ("go back", False)
    assert repr(accepted) == "<Utterance 'go back', accepted, confidence 0.93, 0.20-1.10 s>"
    assert repr(refused) == "<Utterance 'go back', not a command, confidence 0.31, 0.20-1.10 s>"
