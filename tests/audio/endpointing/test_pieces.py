"""What stands out within what goes on."""

from __future__ import annotations

import itertools

from hypothesis import given
from hypothesis import strategies as st

from voz.audio.endpointing.pieces import pieces


def test_what_stands_out_is_found_and_short_gaps_divide_nothing() -> None:
    hum = [40.0] * 20
    usual, found = pieces([*hum, 60, 60, 42, 60, *hum, 55, 55, *hum], above=6, pause=4)
    assert usual == 40
    assert found == [(20, 24), (44, 46)]


def test_what_is_as_loud_all_the_time_has_no_pieces() -> None:
    assert pieces([50.0] * 100, above=3, pause=8) == (50.0, [])


@given(
    st.lists(st.floats(0, 90), min_size=1, max_size=80),
    st.floats(0.5, 10),
    st.integers(1, 10),
)
def test_pieces_are_apart_and_begin_and_end_with_what_stands_out(
    levels: list[float], above: float, pause: int
) -> None:
    usual, found = pieces(levels, above, pause)
    outside = set(range(len(levels)))
    for piece in found:
        assert levels[piece.start] > usual + above
        assert levels[piece.end - 1] > usual + above
        outside -= set(range(*piece))
    assert all(levels[frame] <= usual + above for frame in outside)
    assert all(b.start - a.end >= pause for a, b in itertools.pairwise(found))
