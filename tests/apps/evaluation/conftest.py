"""Results to count, made as a sentence says them."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import pytest

from voz.apps.evaluation.results import Result, Understood

Make = Callable[..., Result]

EVIL = '<script>alert("x")</script>'


@pytest.fixture
def result() -> Make:
    """Make a result: what was said, then what was heard as `text`, or `text?` if refused."""

    def make(said: str, *heard: str, confidence: float = 0.9, **others: Any) -> Result:
        utterances = tuple(
            Understood(text.rstrip("?"), confidence, not text.endswith("?")) for text in heard
        )
        fields = {"set": "mine", "file": said, "speaker": "me", "kind": "command"}
        return Result(
            **({**fields, "condition": "all", "seconds": 1.0} | others),
            text=said,
            heard=utterances,
        )

    return make


@pytest.fixture
def results(result: Make) -> list[Result]:
    """Results of all kinds, with names that a page must not run."""
    return [
        result("stop", "stop", file="a", confidence=0.9),
        result("go back", EVIL, file="b", confidence=0.7, speaker=EVIL, condition=EVIL),
        result(EVIL, "stop", file="b2", set=EVIL),
        result("stop", "stop", file="c", snr=10.0, noise=EVIL, set=EVIL),
        result("stop", "go back", file="c", snr=5.0, noise=EVIL, set=EVIL),
        result("stop it", "stop?", file="d", confidence=0.4, kind="near-miss"),
        result("stop", file=EVIL, error=f"{EVIL}: there is no such file"),
        result(EVIL, "stop", file="e", kind="talk", seconds=60.0),
    ]
