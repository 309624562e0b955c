"""The best sentence of an automaton: compared with scoring each of its sentences by itself."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from voz.language.sentences.automaton import Automaton, minimized, prefix_tree
from voz.recognition.network.ctc import SentenceSearch, best_matches, lattice

BLANK = 6
REWARD = 0.7

# No word ends with a phone that another begins with: there the search asks for no blank between.
WAYS = {
    "a": [[0, 3], [1, 1, 4]],
    "b": [[1, 5]],
    "c": [[2, 0, 2, 4], [2, 3]],
    "d": [[0, 5]],
}

SENTENCES = st.lists(
    st.lists(st.sampled_from(sorted(WAYS)), min_size=1, max_size=4).map(" ".join),
    min_size=1,
    max_size=12,
    unique=True,
)


@given(sentences=SENTENCES, moments=st.integers(1, 25), seed=st.integers(0, 1000))
def test_it_finds_what_fits_best_of_all(sentences: list[str], moments: int, seed: int) -> None:
    random = np.random.default_rng(seed)
    log_ratios = np.log(random.random((moments, BLANK + 1)) + 1e-3)
    before, behind = random.uniform(0, 3, (2, moments))
    found = searched(sentences).search(log_ratios, before, behind)

    # Each pronunciation is a sentence of its own, since each has its own reward.
    every = [(text, way) for text in sentences for way in ways(text)]
    matches = best_matches(
        log_ratios, before, behind, lattice([[[way]] for _, way in every], BLANK)
    )
    scores = matches.scores + REWARD * np.array([len(way) for _, way in every])
    text = found.best
    if not np.isfinite(scores).any():
        assert text == ""
    else:
        own = [score for score, (other, _) in zip(scores, every, strict=True) if other == text]
        assert max(own) == pytest.approx(scores.max())


@given(sentences=SENTENCES, moments=st.integers(1, 25), seed=st.integers(0, 1000))
def test_it_finds_the_beginning_of_another_that_fits_best(
    sentences: list[str], moments: int, seed: int
) -> None:
    random = np.random.default_rng(seed)
    log_ratios = np.log(random.random((moments, BLANK + 1)) + 1e-3)
    before, behind = random.uniform(0, 3, (2, moments))
    automaton = minimized_tree(sentences)
    found = searched(sentences).search(log_ratios, before, behind)
    text, score = found.best_begun(sentences[0])

    said = sentences[0].split()
    through = {automaton.walk(said[:count]) for count in range(len(said) + 1)}
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
    matches = best_matches(log_ratios, before, behind, lattice([[[way]] for way in every], BLANK))
    scores = matches.scores + REWARD * np.array([len(way) for way in every])
    assert score == pytest.approx(scores.max())
    assert text in begun if np.isfinite(score) else text == ""


def minimized_tree(sentences: list[str]) -> Automaton:
    tree = prefix_tree(sentences)
    return minimized(tree.arcs, tree.labels)


def searched(sentences: list[str]) -> SentenceSearch:
    return SentenceSearch(minimized_tree(sentences), WAYS, BLANK, REWARD)


def ways(text: str) -> list[list[int]]:
    """All ways to say a sentence."""
    said: list[list[int]] = [[]]
    for word in text.split():
        said = [[*before, *way] for before in said for way in WAYS[word]]
    return said
