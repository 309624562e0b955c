"""Each promise at each door, in a stepped time with the real parts."""

from __future__ import annotations

import pytest
from promises import tables
from promises.doors import DOORS
from promises.promises import PROMISES, Promise
from promises.run import Door
from recordings import ROOT

CELLS = [(door, promise) for door in DOORS for promise in PROMISES]
KEPT = [(door, promise) for door, promise in CELLS if promise.name not in door.cannot]


@pytest.mark.parametrize(("door", "promise"), KEPT, ids=lambda it: it.name)
def test_a_promise_is_kept_at_a_door(door: Door, promise: Promise) -> None:
    outcome = door.run(promise.given, promise.then, promise.seconds)
    for must in promise.must:
        must(outcome, door)


def test_the_documents_show_the_matrix() -> None:
    written = (ROOT / "docs" / "promises.md").read_text(encoding="utf-8")
    for table in (tables.doors_table(), tables.exits_table()):
        assert "\n".join(table) in written, "`make promises` writes it"
    for promise in PROMISES:
        assert f"\n| **{promise.name}**: {promise.says} |" in written
    safety = (ROOT / "docs" / "safety.md").read_text(encoding="utf-8")
    assert "](promises.md)" in safety


def test_no_cell_is_empty_and_no_reason_is_for_what_nobody_promises() -> None:
    names = {promise.name for promise in PROMISES}
    assert len(names) == len(PROMISES)
    for door in DOORS:
        assert door.cannot.keys() <= names
        assert all(len(reason.split()) > 3 for reason in door.cannot.values())
