"""What speaks for a command: its path through the sound, its rivals', that of any phones."""

from __future__ import annotations

import dataclasses
import itertools
import math
from pathlib import Path

import numpy as np
import pytest
from recordings import Recording

from voz.language.build import build
from voz.language.language_files import LanguageFiles
from voz.language.sentences.command_set import plain_commands
from voz.recognition.language import Language, load_language
from voz.recognition.pocketsphinx.decoder import mean_start
from voz.recognition.pocketsphinx.evidence import (
    MAX_RIVALS,
    SILENCE,
    CommandSearch,
    Evidence,
    FsgArc,
    search_graph,
)
from voz.recognition.thresholds import NEVER_MISSED_TOLERANCE


def ways(arcs: list[FsgArc], end: int) -> set[str]:
    """All sentences from state 0 to the end, without silences."""
    found = {0: {""}}
    steps = sorted((a for a in arcs if a[0] != a[1]), key=lambda arc: arc[1] == end)
    for _ in steps:
        for source, target, _weight, *word in steps:
            more = {" ".join([*one.split(), *word]) for one in found.get(source, ())}
            found.setdefault(target, set()).update(more)
    return found[end]


def test_each_command_is_found_by_its_words() -> None:
    graph = search_graph(["go back", "go", "stop"], ["S", "T"])
    assert {c: ways(graph.arcs, end) for c, end in graph.ends.items()} == {
        "go back": {"go back"},
        "go": {"go"},
        "stop": {"stop"},
    }


def test_what_begins_alike_is_searched_once() -> None:
    graph = search_graph(["go back", "go stop"], ["S"])
    assert [arc[3] for arc in graph.arcs if len(arc) == 4].count("go") == 1


def test_there_may_be_silence_between_words_but_not_within() -> None:
    graph = search_graph(["go back"], ["S"])
    pauses = {arc[0] for arc in graph.arcs if len(arc) == 4 and arc[3] == SILENCE}
    assert len(pauses) == 1 + 2 + 1  # the beginning, after each word, and the loop
    assert {0, graph.loop, *graph.ends.values()} <= pauses


def test_the_loop_holds_any_phones_equally() -> None:
    graph = search_graph(["go"], ["S", "T", "P", "K"])
    loop = [arc for arc in graph.arcs if arc[:2] == (graph.loop, graph.loop) and len(arc) == 4]
    assert [arc[2:] for arc in loop if arc[3] != SILENCE] == [
        (0.25, f"_{phone}") for phone in ("S", "T", "P", "K")
    ]


START = "45,3,-1"


@pytest.fixture(scope="module")
def search(loaded: Language) -> CommandSearch:
    return CommandSearch(loaded)


@pytest.fixture(scope="module")
def commands(recordings: list[Recording]) -> list[Recording]:
    return [r for r in recordings if r.kind == "command" and r.voice == "festival_slt"]


def evidence_of(search: CommandSearch, recording: Recording, text: str = "") -> Evidence:
    evidence = search.compare(recording.samples(), text, mean_start(recording.samples()))
    assert evidence is not None
    return evidence


def test_without_a_sentence_the_command_that_fits_best_is_taken(
    search: CommandSearch, commands: list[Recording]
) -> None:
    assert [evidence_of(search, r).text for r in commands] == [r.text for r in commands]


def test_what_was_said_beats_its_rivals_and_comes_close_to_any_phones(
    search: CommandSearch, commands: list[Recording]
) -> None:
    for recording in commands:
        evidence = evidence_of(search, recording, recording.text)
        assert evidence.text not in evidence.rivals
        assert evidence.rivals  # not all: what is hopelessly far behind drops out
        assert evidence.command.score > max(evidence.rivals.values())
        assert (evidence.command.score - evidence.phones.score) / evidence.phones.frames > -2


def test_the_words_of_a_command_follow_each_other_in_the_sound(
    search: CommandSearch, commands: list[Recording]
) -> None:
    for recording in commands:
        spans = evidence_of(search, recording, recording.text).command.spans
        assert [span.name.partition("(")[0] for span in spans] == recording.text.split()
        assert all(a.start <= a.end < b.start for a, b in itertools.pairwise(spans))
        assert all(span.score < 0 for span in spans)


def test_no_sound_is_no_evidence(search: CommandSearch) -> None:
    assert search.compare(np.zeros(0, np.int16), "stop", START) is None


def test_the_same_audio_gives_the_same_evidence_whatever_came_before(
    loaded: Language, recordings: list[Recording]
) -> None:
    clips = [r.samples() for r in recordings if r.kind in ("command", "near-miss")][::9]
    there, back = CommandSearch(loaded), CommandSearch(loaded)
    forward = [there.compare(clip, "stop", START) for clip in clips]
    assert forward == [back.compare(clip, "stop", START) for clip in clips[::-1]][::-1]


def test_in_doubt_a_command_that_must_not_be_missed_is_taken(
    loaded: Language, commands: list[Recording]
) -> None:
    plain, careful = CommandSearch(loaded), CommandSearch(loaded, ["stop"])
    for recording in commands:
        evidence = evidence_of(plain, recording)
        taken = evidence_of(careful, recording).text
        behind = evidence.command.score - evidence.rivals.get("stop", -math.inf)
        if behind >= NEVER_MISSED_TOLERANCE * evidence.phones.frames:
            assert taken == evidence.text
        assert taken == recording.text  # these are clear


def test_a_command_that_is_hardly_better_gives_way_to_stop(
    loaded: Language, commands: list[Recording]
) -> None:
    both = dataclasses.replace(loaded, commands=plain_commands(["stop speech", "stop"]))
    said = next(r for r in commands if r.text == "stop")
    plain = evidence_of(CommandSearch(both), said, "stop speech")
    assert plain.text == "stop speech"
    assert evidence_of(CommandSearch(both, ["stop"]), said, "stop speech").text == "stop"


def test_stop_does_not_take_what_it_leaves_unexplained(
    loaded: Language, commands: list[Recording], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("voz.recognition.pocketsphinx.evidence.NEVER_MISSED_TOLERANCE", 100.0)
    both = dataclasses.replace(loaded, commands=plain_commands(["stop speech", "stop"]))
    careful = CommandSearch(both, ["stop"])
    for text in both.commands:
        said = next(r for r in commands if r.text == text)
        assert evidence_of(careful, said, "stop speech").text == text


def test_of_a_long_list_those_that_sound_most_like_it_are_rivals(
    commands: list[Recording], tmp_path: Path
) -> None:
    words = ["red", "green", "blue", "black", "white", "brown", "pink", "gray", "gold", "tan"]
    sentences = [f"{a} {b}" for a in words for b in words] + ["go back", "go forward", "stop"]
    (tmp_path / "comandos_voz.txt").write_text("\n".join(sentences))
    build(tmp_path / "comandos_voz.txt", tmp_path)
    search = CommandSearch(load_language(LanguageFiles(tmp_path)))
    assert len(sentences) > MAX_RIVALS
    go_back = next(r for r in commands if r.text == "go back")
    evidence = evidence_of(search, go_back, "go back")
    assert evidence.text == "go back"
    assert {"go forward", "gold black"} <= set(evidence.rivals)
    assert len(evidence.rivals) < MAX_RIVALS
