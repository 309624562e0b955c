"""What every error of voz has."""

from __future__ import annotations

import pickle

import pytest

from voz.errors import ConfigError


@pytest.mark.parametrize(
    ("message", "problem", "remedy"),
    [
        ("there is no microphone; connect one", "there is no microphone", "connect one"),
        ("a: b; do this; or that", "a: b", "do this; or that"),
        ("the disk is full", "the disk is full", None),
    ],
)
def test_an_error_knows_its_problem_and_its_remedy(
    message: str, problem: str, remedy: str | None
) -> None:
    error = ConfigError(message)
    assert (str(error), error.problem, error.remedy) == (message, problem, remedy)


def test_a_text_that_an_error_quotes_may_have_a_semicolon() -> None:
    error = ConfigError("a; b: is no file", "name another")
    assert str(error) == "a; b: is no file; name another"
    assert (error.problem, error.remedy) == ("a; b: is no file", "name another")
    again = pickle.loads(pickle.dumps(error))
    assert (str(again), again.problem, again.remedy) == (str(error), error.problem, error.remedy)
