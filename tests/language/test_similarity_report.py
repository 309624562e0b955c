"""What the user is told of commands that sound alike."""

from __future__ import annotations

from pathlib import Path

import pytest
from recordings import ROOT

from voz.language.build import build
from voz.language.command_source import everyday_neighbors, read_list, similar_pairs
from voz.language.pronunciation import read_cmudict
from voz.language.similarity import SimilarPair, find_similar
from voz.language.similarity_report import (
    command_to_reword,
    neighbor_table,
    rate_in_words,
    similarity_table,
    similarity_warnings,
)

COMMANDS = ROOT / "lm" / "comandos_voz.txt"


@pytest.fixture(scope="module")
def pairs() -> list[SimilarPair]:
    return similar_pairs(read_list(COMMANDS))


def pair(first: str, second: str, alike: float = 0.9) -> SimilarPair:
    return SimilarPair(first, second, alike, ("R T", "P"))


def test_a_warning_says_which_pair_how_alike_why_and_what_to_do():
    assert similarity_warnings([pair("start speech", "stop speech")]) == (
        '"start speech" and "stop speech" sound alike '
        "(0.90: R T / P differ; 1 in 100 are mixed up in noise); "
        'use another word for one, best in "stop speech"',
    )


def test_what_sounds_the_same_has_no_phones_that_differ():
    words = {"right": ["R AY T"], "write": ["R AY T"]}
    (line,) = similarity_warnings(find_similar(["right", "write"], words))
    assert "(1.00: no phone differs; 50 in 100 are" in line


def test_pairs_that_are_hardly_alike_give_no_warning():
    assert similarity_warnings([pair("go back", "stop", alike=0.7)]) == ()


def test_pairs_that_are_known_are_told_no_more_and_the_worst_come_first():
    pairs = [pair("go", "no", 0.9), pair("start", "stop", 0.95), pair("arm", "on", 0.93)]
    lines = similarity_warnings(pairs, known=[{"go", "start"}, {"start", "stop", "on"}])
    assert [line.partition(" sound")[0] for line in lines] == ['"arm" and "on"', '"go" and "no"']


def test_many_warnings_are_ten_lines_the_worst_first_and_all_if_wanted():
    pairs = [pair(f"go {n}", f"no {n}", 0.99 - n / 200) for n in range(20)]
    lines = similarity_warnings(pairs)
    assert len(lines) == 10
    assert lines[:9] == similarity_warnings(pairs[:9])
    assert lines[9] == "11 more pairs sound alike; `voz build-lm --all` shows them"
    every = similarity_warnings(pairs, every=True)
    assert every == (
        *lines[:9],
        *similarity_warnings(pairs[9:19]),
        *similarity_warnings(pairs[19:]),
    )
    assert len(similarity_warnings(pairs[:10])) == 10


def test_the_command_that_is_close_to_others_too_is_the_one_to_reword():
    pairs = [pair("arm up", "turn up"), pair("arm up", "arm off", 0.7)]
    assert command_to_reword(pairs[0], pairs) == "arm up"


def test_stop_is_never_the_one_to_reword():
    pairs = [pair("stomp", "stop"), pair("stop", "top"), pair("stop", "shop")]
    assert [command_to_reword(p, pairs) for p in pairs] == ["stomp", "top", "shop"]


def test_the_table_shows_the_closest_pairs(pairs: list[SimilarPair]):
    head, first, *rest = similarity_table(pairs).splitlines()
    assert head.split() == ["alike", "mixed", "up", "in", "noise", "commands", "what", "differs"]
    how = rate_in_words(pairs[0].similarity)
    assert (
        first.split() == f"{pairs[0].similarity:.2f} {how} start speech stop speech R T / P".split()
    )
    assert len(rest) == 9
    assert len(similarity_table(pairs * 2, every=True).splitlines()) == 1 + 2 * len(pairs)
    assert similarity_table([]) == "no two commands sound alike"


def test_building_the_list_that_comes_with_voz_warns_of_nothing(tmp_path: Path):
    assert build(COMMANDS, tmp_path).warnings == ()


def test_a_longer_list_is_warned_of_its_own_pairs_alone(tmp_path: Path):
    own = tmp_path / "list.txt"
    own.write_text(f"{COMMANDS.read_text()}open gripper\nstop peach\n")
    worst, other = build(own, tmp_path).warnings
    assert worst.startswith('"stop speech" and "stop peach" sound alike')
    assert build(own, tmp_path, before=["stop peach", "stop speech"]).warnings == (other,)


def test_of_a_long_list_some_are_compared_with_their_neighbors(tmp_path: Path):
    words = [line.split()[0].decode() for line in read_cmudict().split(b"\n")[20_000:60_000:50]]
    usable = [word for word in words if word.isalpha()][:120]
    path = tmp_path / "list.txt"
    path.write_text("\n".join(f"go {one} {other}" for one in usable for other in usable[:3]))
    pairs = similar_pairs(read_list(path))
    assert pairs
    assert pairs == sorted(pairs, key=lambda pair: -pair.similarity)
    assert len(similarity_warnings(pairs)) <= 10


def test_what_means_the_same_may_sound_alike(tmp_path: Path):
    (tmp_path / "list.txt").write_text("go: go (right|write)\ncome back\n")
    assert build(tmp_path / "list.txt", tmp_path).warnings == ()
    (tmp_path / "list.txt").write_text("bring me the {side} cup\nside = right | write")
    (line,) = build(tmp_path / "list.txt", tmp_path).warnings
    assert 'best in "bring me the write cup": say "right" or "write" in another way' in line


def test_everyday_phrases_that_sound_like_a_command_are_named(tmp_path: Path):
    (tmp_path / "list.txt").write_text("fold arm\nhold arm\nxylophone\n")
    near = everyday_neighbors(read_list(tmp_path / "list.txt"))
    assert "fold armor" in near["fold arm"]
    assert "hold arm" not in near["fold arm"]  # a command
    assert neighbor_table(near).splitlines() == [
        "command   one sound away, in everyday words; not all of them are refused",
        f"fold arm  {', '.join(near['fold arm'])}",
        f"hold arm  {', '.join(near['hold arm'])}",
    ]
    assert (
        neighbor_table({"xylophone": []}) == "no everyday phrase is one sound away from a command"
    )


def test_ten_commands_are_told_of_unless_all_are_wanted():
    near = {f"command {number}": ["phrase"] for number in range(12)}
    assert (
        neighbor_table(near).splitlines()[-1] == "and 2 more commands; `voz build-lm --alike --all`"
    )
    assert len(neighbor_table(near, every=True).splitlines()) == 13


def test_a_long_list_is_sampled(tmp_path: Path):
    (tmp_path / "list.txt").write_text("turn to {n: 1..2000}\nstop\n")
    assert 0 < len(everyday_neighbors(read_list(tmp_path / "list.txt"))) <= 100
