"""What a recognizer tells of an utterance beyond the command, if asked: it costs time."""

from __future__ import annotations

from typing import Annotated

import msgspec
from msgspec.structs import replace

from voz.events import Alternative, Utterance
from voz.recognition.confidence import Context, discount_for_context
from voz.recognition.hypothesis import Hypothesis
from voz.records import CheckedRecord

MAX_BEST = 100
"""Most alternatives of an utterance."""


class Details(CheckedRecord, frozen=True):
    """What is asked for."""

    words: bool = False  # when each word was said
    best: Annotated[int, msgspec.Meta(ge=0, le=MAX_BEST)] = 0  # how many alternatives


NO_DETAILS = Details()


def with_details(
    utterance: Utterance, heard: Hypothesis, context: Context, details: Details
) -> Utterance:
    """Add to the utterance of a hypothesis what is asked for."""
    return replace(
        utterance,
        words=heard.words() if details.words else (),
        best=_best(utterance, heard, context, details.best),
    )


def _best(
    utterance: Utterance, heard: Hypothesis, context: Context, count: int
) -> tuple[Alternative, ...]:
    """The utterance and its rivals; none has more confidence than the ones before it leave."""
    if not count or not heard.values:
        return ()
    found = [Alternative(utterance.text, utterance.confidence)]
    left = 1 - utterance.confidence
    for text, likely in heard.others(count - 1):
        sure = min(discount_for_context(likely, context), found[-1].confidence, left)
        found.append(Alternative(text, round(sure, 3)))
        left = max(0.0, left - found[-1].confidence)
    return tuple(found)
