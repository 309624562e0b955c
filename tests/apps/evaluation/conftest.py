"""Results to count, made as a sentence says them."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import pytest

from voz.apps.evaluation.results import Result, Understood

Make = Callable[..., Result]


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
