"""What is heard where a name fits best."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from voz.recognition.ctc import Floats, lattice
from voz.recognition.name_evidence import (
    AROUND,
    LEAST_LIKELY,
    LENGTH_LIMITS,
    NameEvidence,
    NameWeights,
    find_evidence,
    read_weights,
    write_weights,
)

PHONES, BLANK = 3, 3
ZERO = LEAST_LIKELY / 2


def sound(*heard: int) -> Floats:
    """A sound in which one symbol is likely at each moment."""
    relative = np.full((len(heard), PHONES + 1), -20.0)
    relative[np.arange(len(heard)), list(heard)] = 0
    return relative


def evidence(relative: Floats, *phones: int) -> NameEvidence:
    nothing = np.zeros(len(relative))
    return find_evidence(relative, nothing, nothing, lattice([[[phones]]], BLANK))


def test_each_phone_has_what_is_heard_while_it_is_said() -> None:
    relative = sound(BLANK, BLANK, 0, 0, BLANK, BLANK, BLANK, 1, BLANK, BLANK, BLANK, 2)
    relative[5, 2] = -1  # two moments after the first phone
    relative[6, 0] = -1  # just before the second one, and no longer with the first
    found = evidence(relative, 0, 1)
    assert (found.begin, found.end, found.fit) == (2, 8, 0)
    assert found.phones.tolist() == [0, 1]
    first, second = (found.heard + ZERO).tolist()
    assert first == [0, LEAST_LIKELY, -1, LEAST_LIKELY]
    assert second == [-1, 0, LEAST_LIKELY, LEAST_LIKELY]
    assert found.lengths.tolist() == np.searchsorted(LENGTH_LIMITS, [5, 3]).tolist()


def test_what_is_said_around_it_is_told_apart() -> None:
    relative = sound(BLANK, 0, 1, BLANK)
    before, behind = np.array([9.0, 2, 9, 9]), np.array([9.0, 9, 3, 9])
    found = find_evidence(relative, before, behind, lattice([[[[0, 1]]]], BLANK))
    assert (found.fit, found.around) == (0, 5)


def test_a_phone_that_comes_twice_is_two() -> None:
    found = evidence(sound(0, BLANK, 0, 0, 1), 0, 0, 1)
    assert found.phones.tolist() == [0, 0, 1]
    assert found.heard.shape == (3, PHONES + 1)


def test_a_name_that_is_longer_than_the_sound_was_not_said() -> None:
    found = evidence(sound(0, 1), 0, 1, 2, 0)
    heard, lengths = np.ones((PHONES, PHONES + 1)), np.ones((PHONES, 10))
    weights = NameWeights(9.0, 0.5, heard, lengths, np.ones(3))
    assert found.phones.size == 0
    assert found.log_odds(weights) == -np.inf


def test_the_log_odds_add_up() -> None:
    heard = np.arange(PHONES * (PHONES + 1), dtype=float).reshape(PHONES, -1)
    lengths = np.arange(PHONES * 10, dtype=float).reshape(PHONES, -1)
    weights = NameWeights(-2.0, 0.5, heard, lengths, np.zeros(PHONES))
    seen = np.array([[1.0, 0, 0, 0], [0, 0, 2.0, 0]])
    found = NameEvidence(-4.0, 5.0, 0, 9, np.array([2, 1]), seen, np.array([3, 0]))
    told = (heard[2, 0] + 2 * heard[1, 2]) + (23 + 10)
    assert found.log_odds(weights) == -2 - 2 - 5 * AROUND + told


def test_weights_are_read_as_they_were_written(tmp_path: Path) -> None:
    usual = read_weights()
    write_weights(usual, tmp_path / "weights.npz")
    again = read_weights(tmp_path / "weights.npz")
    for one, other in zip(usual, again, strict=True):
        np.testing.assert_array_equal(one, other)
    assert again.constant == pytest.approx(usual.constant)
