"""Labeled utterances are collected from recordings, each with what was said where it is."""

from __future__ import annotations

from pathlib import Path

import pytest
from msgspec.structs import replace
from recordings import FIXTURES

from voz.apps.evaluation.examples import check_talk, collect_examples, describe_set
from voz.apps.recordings.manifest import Clip, read_manifest
from voz.errors import ConfigError


def test_a_set_is_described_by_its_kinds_and_speakers() -> None:
    clips = read_manifest(FIXTURES / "manifest.tsv")
    kinds = {clip.kind for clip in clips}
    said = describe_set(clips, clips[0].set)
    assert all(f" {kind}" in said for kind in kinds)
    assert said.endswith(f"; {len({clip.speaker for clip in clips})} speakers")


def test_recordings_without_talk_are_refused_before_they_are_recognized() -> None:
    clips = [c for c in read_manifest(FIXTURES / "manifest.tsv") if c.kind != "talk"]
    with pytest.raises(ConfigError, match="of the kind talk, half an hour or so"):
        check_talk(clips)
    check_talk([*clips, replace(clips[0], kind="talk")])


def test_in_a_stream_everything_belongs_to_what_was_said_there(tmp_path: Path) -> None:
    session = FIXTURES / "long" / "session.wav"
    said = Clip("lab", "session.wav", session, "start speech", "me", "command", "all", 0.5, 2.0)
    other = replace(said, text="", kind="near-miss", start=2.5, end=4.0)
    (collected,) = collect_examples([said, other], None, 1)
    for examples in (collected.examples, collected.alone):
        kinds = [(e.clip.kind, e.text, e.right) for e in examples]
        assert kinds[:2] == [("command", "start speech", True), ("near-miss", "go forward", False)]
        assert {kind for kind, _, _ in kinds[2:]} == {"noise"}
    assert collected.talk == 0
