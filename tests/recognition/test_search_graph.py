"""Commands and a loop of phones are laid side by side."""

from __future__ import annotations

from voz.recognition.search_graph import SILENCE, Arc, search_graph


def ways(arcs: list[Arc], end: int) -> set[str]:
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
