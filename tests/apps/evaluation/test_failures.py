from __future__ import annotations

from typing import Any

import pytest
from msgspec.structs import replace

from voz.apps.evaluation.failures import (
    MISHEARD,
    OBEYED,
    REFUSED,
    UNHEARD,
    UNREAD,
    WORST_FIRST,
    Failure,
    failures,
)
from voz.apps.evaluation.results import Understood


@pytest.mark.parametrize(
    ("said", "heard", "others", "what"),
    [
        ("stop", ["stop"], {}, None),
        ("stop", ["stop?"], {}, REFUSED),
        ("stop", ["go back?"], {}, MISHEARD),
        ("stop", ["go back"], {}, OBEYED),
        ("stop", ["stop", "stop"], {}, MISHEARD),
        ("stop", [], {}, UNHEARD),
        ("stop", ["?"], {}, UNHEARD),
        ("stop", [], {"error": "none.wav: there is no such file"}, UNREAD),
        ("stop | go back", ["stop", "go back"], {"kind": "long"}, None),
        ("stop | go back", ["stop"], {"kind": "long"}, MISHEARD),
        ("stop it", ["stop?"], {"kind": "near-miss"}, None),
        ("stop it", ["stop"], {"kind": "near-miss"}, OBEYED),
        ("la la", ["stop?"], {"kind": "talk"}, None),
        ("", ["stop"], {"kind": "noise"}, OBEYED),
        ("", ["stop"], {"kind": "out-of-nothing"}, OBEYED),
    ],
)
def test_what_went_wrong(
    result: Any, said: str, heard: list[str], others: dict[str, Any], what: str | None
) -> None:
    found = failures([result(said, *heard, **others)])
    assert [failure.what for failure in found] == ([what] if what else [])


def test_in_a_stream_the_stretch_is_named_and_in_talk_what_was_obeyed(result: Any) -> None:
    talk = replace(
        result("", kind="talk"),
        heard=(
            Understood("stop", 0.9, True, 0.2, 1.0),
            Understood("go back", 0.1, False, 3.0, 4.0),
            Understood("go back", 0.8, True, 100.0, 101.0),
        ),
    )
    (first, second, third) = failures([result("stop", start=2.5, end=3.5), talk])
    assert (first.number, first.stretch) == (1, (0.0, 1.5))
    assert second == Failure(1, OBEYED, (talk.heard[2],), (99.5, 101.5))
    assert third == Failure(0, UNHEARD, (), (2.5, 3.5))


def test_the_worst_is_first_and_the_rest_in_its_order(result: Any) -> None:
    results = [
        result("stop", error="unreadable"),
        result("stop"),
        result("stop", "stop?"),
        result("stop", "go back?"),
        result("stop", "go back"),
        result("stop", "turn left"),
    ]
    assert [failure.number for failure in failures(results)] == [4, 5, 3, 2, 1, 0]
    assert [failure.what for failure in failures(results)][1:] == list(WORST_FIRST)
