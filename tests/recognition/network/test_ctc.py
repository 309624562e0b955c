"""Where a sentence fits best: compared with trying every beginning, end and way to spread it."""

from __future__ import annotations

import math
from collections.abc import Iterator
from itertools import combinations_with_replacement, groupby, product

import numpy as np
import pytest
from hypothesis import assume, given
from hypothesis import strategies as st

from voz.language.sentences.automaton import Automaton, minimized, prefix_tree
from voz.recognition.network.ctc import (
    Floats,
    SentenceSearch,
    align,
    best_matches,
    lattice,
    longest_gap,
)

BLANK = 2
SYMBOLS = 3

Sentence = list[list[list[int]]]

WAYS = st.lists(
    st.lists(st.integers(0, 1), min_size=1, max_size=3), min_size=1, max_size=2, unique_by=tuple
)
SENTENCES = st.lists(st.lists(WAYS, min_size=1, max_size=3), min_size=1, max_size=4)


def made_up(moments: int, seed: int) -> tuple[Floats, Floats, Floats]:
    """What was heard, and what it costs to begin and to end at each moment."""
    random = np.random.default_rng(seed)
    chance = random.random((moments, SYMBOLS)) + 0.01
    log_ratios = np.log(chance / chance.max(axis=1, keepdims=True))
    return log_ratios, random.uniform(0, 3, moments), random.uniform(0, 3, moments)


def paths(sentence: Sentence, moments: int) -> Iterator[tuple[int, ...]]:
    """All that sounds like the sentence, from its first symbol to its last."""
    for path in product(range(SYMBOLS), repeat=moments):
        if says(path, sentence):
            yield path


def says(path: tuple[int, ...], sentence: Sentence) -> bool:
    """Whether a path is all words one after another; blanks may lie between."""
    first, *others = sentence
    for end in range(1, len(path) + 1):
        heard = [symbol for symbol, _ in groupby(path[:end]) if symbol != BLANK]
        if heard in first and BLANK not in (path[0], path[end - 1]):
            rest = path[end:]
            if says(rest[blanks(rest) :], others) if others else not rest:
                return True
    return False


def blanks(path: tuple[int, ...]) -> int:
    """How many blanks a path begins with."""
    return next((n for n, symbol in enumerate(path) if symbol != BLANK), len(path))


def tried(heard: tuple[Floats, Floats, Floats], sentence: Sentence) -> dict[tuple[int, int], float]:
    """The score of the best path from each moment to each that follows, where there is one."""
    log_ratios, before, behind = heard
    found: dict[tuple[int, int], float] = {}
    for begin, end in combinations_with_replacement(range(len(log_ratios)), 2):
        stretch = log_ratios[begin : end + 1]
        for path in paths(sentence, len(stretch)):
            score = sum(row[symbol] for row, symbol in zip(stretch, path, strict=True))
            score -= before[begin] + behind[end]
            found[begin, end] = max(score, found.get((begin, end), -math.inf))
    return found


@given(SENTENCES, st.integers(1, 5), st.integers(0, 2**32 - 1))
def test_it_is_the_best_of_all_paths_and_lies_where_it_says(
    sentences: list[Sentence], moments: int, seed: int
) -> None:
    heard = made_up(moments, seed)
    found = best_matches(*heard, lattice(sentences, BLANK))
    for sentence, score, begin, end in zip(sentences, *found, strict=True):
        scores = tried(heard, sentence)
        assert score == pytest.approx(max(scores.values(), default=-math.inf))
        if scores:
            assert scores[begin, end] == pytest.approx(score)


def best_path(
    heard: tuple[Floats, Floats, Floats], sentence: Sentence
) -> tuple[int, tuple[int, ...]] | None:
    """Where the best of all paths of a sentence begins, and the path; None if there is none."""
    log_ratios, before, behind = heard
    found = [
        (
            sum(row[symbol] for row, symbol in zip(log_ratios[begin:], path, strict=False)),
            begin,
            path,
        )
        for begin in range(len(log_ratios))
        for length in range(1, len(log_ratios) - begin + 1)
        for path in paths(sentence, length)
    ]
    costs = [before[begin] + behind[begin + len(path) - 1] for _, begin, path in found]
    scores = [score - cost for (score, *_), cost in zip(found, costs, strict=True)]
    return found[int(np.argmax(scores))][1:] if found else None


@given(st.lists(WAYS, min_size=1, max_size=3), st.integers(1, 5), st.integers(0, 2**32 - 1))
def test_each_word_is_where_the_best_of_all_paths_has_it(
    sentence: Sentence, moments: int, seed: int
) -> None:
    heard = made_up(moments, seed)
    best = best_path(heard, sentence)
    assume(best is not None)
    assert best
    begin, path = best
    places = align(*heard, lattice([sentence], BLANK))
    assert (places[0][0], places[-1][1]) == (begin, begin + len(path) - 1)
    rest = begin
    for (first, last), ways in zip(places, sentence, strict=True):
        said = path[first - begin : last - begin + 1]
        assert [symbol for symbol, _ in groupby(said) if symbol != BLANK] in ways
        assert BLANK not in (said[0], said[-1])
        assert {*path[rest - begin : first - begin]} <= {BLANK}
        rest = last + 1


def found_in(heard: tuple[Floats, Floats, Floats], sentence: Sentence) -> tuple[float, int, int]:
    """The score of a sentence, and its first and last moment."""
    (score,), (begin,), (end,) = best_matches(*heard, lattice([sentence], BLANK))
    return float(score), int(begin), int(end)


def silence_around(word: list[int], at: int, moments: int) -> Floats:
    """Nothing but the blank is heard, and a word once, a moment for each symbol."""
    log_ratios = np.full((moments, SYMBOLS), -20.0)
    log_ratios[:, BLANK] = 0
    for place, symbol in enumerate(word):
        log_ratios[at + place] = np.where(np.arange(SYMBOLS) == symbol, 0.0, -20.0)
    return log_ratios


@pytest.mark.parametrize("at", [0, 1234, 4997])
def test_a_word_is_found_wherever_it_is_in_a_long_stream(at: int) -> None:
    nothing = np.zeros(5000)
    heard = silence_around([0, 1, 0], at, 5000), nothing, nothing
    assert found_in(heard, [[[0, 1, 0]]]) == (0, at, at + 2)
    score, *_ = found_in(heard, [[[1, 0, 1]]])
    assert score == -20


@pytest.mark.parametrize(
    ("heard", "sentence", "gap"),
    [
        ("0221", [[[0, 1]]], 2),
        ("02212220", [[[0, 1, 0]]], 3),
        ("01", [[[0, 1]]], 0),
        ("0222122", [[[0]], [[1]]], 0),  # between two words
        ("02122220", [[[0, 1]], [[0]]], 1),
        ("222", [[[0]]], 0),
    ],
)
def test_the_longest_gap_is_within_a_word(heard: str, sentence: Sentence, gap: int) -> None:
    log_ratios = np.full((len(heard), SYMBOLS), -20.0)
    log_ratios[range(len(heard)), [int(symbol) for symbol in heard]] = 0
    free = np.zeros(len(heard))
    assert longest_gap(log_ratios, free, free, lattice([sentence], BLANK)) == gap


def test_what_it_costs_to_begin_and_end_is_weighed_against_the_sound() -> None:
    log_ratios, nothing = silence_around([0], 2, 4), np.zeros(4)
    for cost, best, begins in ((5.0, -5, {2}), (50.0, -20, {0, 1})):
        late = np.array([0, 0, cost, cost])
        score, begin, _ = found_in((log_ratios, late, nothing), [[[0]]])
        assert (score, begin in begins) == (best, True)
    early = np.array([50.0, 50, 50, 0])
    score, _, end = found_in((log_ratios, nothing, early), [[[0]]])
    assert (score, end) == (-20, 3)


def test_what_a_word_ends_with_may_be_heard_once_where_the_next_begins_so() -> None:
    log_ratios, nothing = silence_around([0, 1, 1, 0], 2, 8), np.zeros(8)
    assert found_in((log_ratios, nothing, nothing), [[[0, 1]], [[1, 0]]]) == (0, 2, 5)
    score, *_ = found_in((log_ratios, nothing, nothing), [[[0, 1, 1, 0]]])
    assert score < -15


NO_PHONE = 6
REWARD = 0.7

SEARCHED_WAYS = {
    "a": [[0, 3], [1, 1, 5]],
    "b": [[5, 1]],
    "c": [[2, 0, 2, 4], [2, 3]],
    "d": [[0, 5]],
}

SEARCHED = st.lists(
    st.lists(st.sampled_from(sorted(SEARCHED_WAYS)), min_size=1, max_size=4).map(" ".join),
    min_size=1,
    max_size=12,
    unique=True,
)


@given(sentences=SEARCHED, moments=st.integers(1, 25), seed=st.integers(0, 1000))
def test_it_finds_what_fits_best_of_all(sentences: list[str], moments: int, seed: int) -> None:
    random = np.random.default_rng(seed)
    log_ratios = np.log(random.random((moments, NO_PHONE + 1)) + 1e-3)
    before, behind = random.uniform(0, 3, (2, moments))
    found = searched(sentences).search(log_ratios, before, behind)

    # Each pronunciation is a sentence of its own, since each has its own reward.
    every = [(text, words) for text in sentences for words in ways(text)]
    said = [words for _, words in every]
    scores = best_matches(log_ratios, before, behind, lattice(said, NO_PHONE)).scores
    scores = scores + rewards(said)
    text = found.best
    if not np.isfinite(scores).any():
        assert text == ""
    else:
        own = [score for score, (other, _) in zip(scores, every, strict=True) if other == text]
        assert max(own) == pytest.approx(scores.max())


@given(
    sentences=SEARCHED,
    moments=st.integers(1, 25),
    seed=st.integers(0, 1000),
    itself=st.booleans(),
)
def test_it_finds_the_beginning_that_fits_best(
    sentences: list[str], moments: int, seed: int, itself: bool
) -> None:
    random = np.random.default_rng(seed)
    log_ratios = np.log(random.random((moments, NO_PHONE + 1)) + 1e-3)
    before, behind = random.uniform(0, 3, (2, moments))
    automaton = minimized_tree(sentences)
    found = searched(sentences).search(log_ratios, before, behind)
    text, score = found.best_begun(sentences[0], itself=itself)

    said = sentences[0].split()
    through = {automaton.walk(said[:count]) for count in range(len(said) + 1)}
    through = {automaton.walk(said)} if itself else through
    begun = {
        " ".join(words)
        for sentence in sentences
        for count in range(1, len(sentence.split()) + 1)
        if automaton.walk(words := sentence.split()[:count]) not in through
    }
    every = [way for each in begun for way in ways(each)]
    if not every:
        assert (text, score) == ("", -np.inf)
        return
    scores = best_matches(log_ratios, before, behind, lattice(every, NO_PHONE)).scores
    scores = scores + rewards(every)
    assert score == pytest.approx(scores.max())
    assert text in begun if np.isfinite(score) else text == ""


def minimized_tree(sentences: list[str]) -> Automaton:
    tree = prefix_tree(sentences)
    return minimized(tree.arcs, tree.labels)


def searched(sentences: list[str]) -> SentenceSearch:
    return SentenceSearch(minimized_tree(sentences), SEARCHED_WAYS, NO_PHONE, REWARD)


def ways(text: str) -> list[Sentence]:
    """All ways to say a sentence: each word in one."""
    said: list[Sentence] = [[]]
    for word in text.split():
        said = [[*before, [way]] for before in said for way in SEARCHED_WAYS[word]]
    return said


def rewards(said: list[Sentence]) -> Floats:
    """The reward of each way to say a sentence."""
    return np.array([REWARD * sum(len(way) for (way,) in words) for words in said])
