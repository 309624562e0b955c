"""What was heard in place of which command, by speaker: a confusion matrix without its diagonal.

Pure.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterable

import msgspec

from voz.apps.evaluation.results import Result

REFUSED = "refused"
NOT_HEARD = "not heard"


class Confusion(msgspec.Struct, frozen=True):
    """A command that was misheard."""

    said: str
    heard: str  # what would be obeyed instead; empty if nothing would
    outcome: str  # `as COMMAND`, `more than once`, `refused`, or `not heard`
    speakers: dict[str, int]  # clips by speaker, the one with the most first

    @property
    def clips(self) -> int:
        """How many clips of all speakers."""
        return sum(self.speakers.values())


def confusions(results: Iterable[Result]) -> list[Confusion]:
    """Count the misheard commands, the most frequent first; clips of several are left out."""
    counted: dict[tuple[str, str, str], Counter[str]] = {}
    for result in results:
        if result.kind == "command" and not result.is_right_and_accepted:
            for heard, outcome in _outcomes(result):
                found = counted.setdefault((result.text, heard, outcome), Counter())
                found[result.speaker] += 1
    rows = [Confusion(*key, dict(of.most_common())) for key, of in counted.items()]
    return sorted(rows, key=lambda row: (-row.clips, row.said, row.outcome))


def _outcomes(result: Result) -> list[tuple[str, str]]:
    """What became of a misheard command; if it was obeyed too, what was obeyed besides."""
    wrong = [text for text in dict.fromkeys(result.obeyed) if text != result.text]
    if wrong:
        return [(text, f"as {text}") for text in wrong]
    if result.obeyed:
        return [(result.text, "more than once")]
    return [("", REFUSED if result.texts else NOT_HEARD)]
