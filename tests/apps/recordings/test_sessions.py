"""Sessions that were kept are read back: events as lines of JSON, and bags."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import pytest
from driving import type_lines

from voz.apps.recordings.bags import write_bag
from voz.apps.recordings.sessions import read_session
from voz.errors import ConfigError
from voz.events import Event, SelectedObject, Twist, Utterance, to_json

LINES = ["start speech", "go forward", "dance", "-", "point beer", "turn left", *"----", "stop"]


@pytest.fixture
def events() -> list[Event]:
    events: list[Event] = []
    type_lines(LINES, events.append)
    return events


def test_what_was_written_as_json_is_read_back_whole(tmp_path: Path, events: list[Event]) -> None:
    path = tmp_path / "drive.jsonl"
    path.write_text("".join(f"{to_json(event)}\n" for event in events) + '{"type":"cmd_v')
    assert read_session(path) == events  # but for what a power failure cut short


@pytest.mark.parametrize("name", ["drive.mcap", "drive.db3", "drive.bag", "drive"])
def test_of_a_bag_there_is_what_was_published(
    name: str, tmp_path: Path, events: list[Event]
) -> None:
    with write_bag(tmp_path / name) as receive:
        for event in events:
            receive(event)
    read = read_session(tmp_path / name)
    for kind in (Twist, SelectedObject):
        assert [e for e in read if isinstance(e, kind)] == [e for e in events if type(e) is kind]
    heard = [(e.t, e.text) for e in events if isinstance(e, Utterance) and e.obeyed]
    assert [(e.t, e.text) for e in read if isinstance(e, Utterance)] == heard


@pytest.mark.parametrize(
    ("text", "complaint"),
    [
        ("", "has no events; name what"),
        ("{}\n", "drive.jsonl:1: is not an event of voz"),
        ('{"type":"dance","t":1}\n', "drive.jsonl:1: is not an event of voz"),
        ("[" * 100_000 + "\n", "drive.jsonl:1: is not an event of voz"),
    ],
)
def test_what_is_no_session_is_one_line(text: str, complaint: str, tmp_path: Path) -> None:
    path = tmp_path / "drive.jsonl"
    path.write_text(text)
    with pytest.raises(ConfigError, match=complaint) as caught:
        read_session(path)
    assert "\n" not in str(caught.value)


def test_what_is_not_there_is_one_line(voz: Any, tmp_path: Path) -> None:
    assert "cannot be read" in voz("view", tmp_path / "none.jsonl").complaint
    assert "there is no such bag" in voz("view", tmp_path / "none.mcap").complaint
