"""The best sentence of an automaton: compared with scoring each of its sentences by itself."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from voz.language.sentences.automaton import minimized, prefix_tree
from voz.recognition.ctc import best_matches, lattice
from voz.recognition.sentence_search import SentenceSearch

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
    relative = np.log(random.random((moments, BLANK + 1)) + 1e-3)
    before, behind = random.uniform(0, 3, (2, moments))
    tree = prefix_tree(sentences)
    search = SentenceSearch(minimized(tree.arcs, tree.labels), WAYS, BLANK, REWARD)

    # Each pronunciation is a sentence of its own, since each has its own reward.
    every = [(text, way) for text in sentences for way in ways(text)]
    found = best_matches(relative, before, behind, lattice([[[way]] for _, way in every], BLANK))
    scores = found.scores + REWARD * np.array([len(way) for _, way in every])
    text = search.best(relative, before, behind)
    if not np.isfinite(scores).any():
        assert text == ""
    else:
        own = [score for score, (other, _) in zip(scores, every, strict=True) if other == text]
        assert max(own) == pytest.approx(scores.max())


def ways(text: str) -> list[list[int]]:
    """All ways to say a sentence."""
    said: list[list[int]] = [[]]
    for word in text.split():
        said = [[*before, *way] for before in said for way in WAYS[word]]
    return said
